"""Where entries of the cache are read: a folder of files, or a pack (`strandcli.compiling.packs`).

An entry is run as code. So a store is trusted by who owns it, and an entry by its own hash as well.
"""

from __future__ import annotations

import contextlib
import os
import stat
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

from ..files.inputs import READ
from .clock import clock

T = TypeVar("T")
DAY = 86_400.0
ROOT = 0
"""The user who may change everything anyway."""


class Store:
    """A place where entries are read by their names."""

    made: dict[str, Any] | None = None
    """What the kernels of a pack were compiled with; None for those of this process' own settings."""
    damage: str | None = None
    """A line on the first entry that was not what was written."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def opened(self, name: str) -> contextlib.AbstractContextManager[BinaryIO]:
        """An entry. Raises `FileNotFoundError` where there is none, and `OSError` or `ValueError` for what is not
        trusted."""
        raise NotImplementedError

    def discard(self, name: str) -> None:
        """Remove an entry that is not what was written, where that can be done."""

    def load(self, name: str, read: Callable[[BinaryIO], T]) -> T | None:
        """What ``read`` makes of an entry; None where there is none, or where it raises, which is told."""
        try:
            with self.opened(name) as file:
                return read(file)
        except FileNotFoundError:
            return None
        except Exception as error:
            words = f"{self.path / name}: is not used ({error or 'it is of something else'}): made anew"
            self.damage = self.damage or words
            clock.tell(words)
            self.discard(name)
            return None


class FolderStore(Store):
    """Files of a folder."""

    def __init__(self, path: Path, owner: int | None = None) -> None:
        """``owner``: a user who may own the files, beside this one and root."""
        super().__init__(path)
        self._owner = owner

    @contextlib.contextmanager
    def opened(self, name: str) -> Iterator[BinaryIO]:
        """An entry, whose time says at least to the day when it was last used."""
        path = self.path / name
        with open(os.open(path, READ | getattr(os, "O_NOFOLLOW", 0)), "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode):
                raise ValueError("it is no file")
            if others := writers(status, self._owner):
                raise ValueError(others)
            if status.st_mtime < time.time() - DAY:
                with contextlib.suppress(OSError):
                    os.utime(path)
            yield file

    def discard(self, name: str) -> None:
        """Remove a file; a folder in its place if it is empty."""
        for remove in (os.unlink, os.rmdir):
            with contextlib.suppress(OSError):
                remove(self.path / name)
                return


def writers(found: os.stat_result, owner: int | None = None) -> str:
    """Who but this user, root and ``owner`` may change a folder or a file of the cache, in words; "" where nobody may,
    and on systems that have no such owners."""
    if not hasattr(os, "getuid"):
        return ""
    if found.st_uid not in (os.getuid(), ROOT, owner):
        return "it belongs to another user"
    return "other users may change it" if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else ""
