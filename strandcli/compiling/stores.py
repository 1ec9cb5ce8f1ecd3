"""Where entries of the cache are read: a folder of files, or a pack.

An entry is run as code. So a store is trusted by who owns it, and an entry by its own hash as well.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import re
import stat
import time
import zipfile
from collections.abc import Callable, Iterator, Mapping
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
        """What ``read`` makes of an entry; None where there is none, or where it raises, which is reported."""
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
            if writable_by := writers(status, self._owner):
                raise ValueError(writable_by)
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
    """Who but this user, root and ``owner`` may change a folder or a file of the cache, in words; "" where none may,
    and on systems that have no such owners."""
    if not hasattr(os, "getuid"):
        return ""
    if found.st_uid not in (os.getuid(), ROOT, owner):
        return "it belongs to another user"
    return "other users may change it" if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else ""


MAGIC = b"strandcli pack 1\n"
MANIFEST = "pack.json"
ENTRY = re.compile(r"[\w.<>]+-[0-9a-f]{24}\.kernel|[a-z-]+-[0-9a-f]{24}\.arrays", re.ASCII)
MOST_BYTES = 1 << 30
"""Of a pack, and of all that is in it."""
SHIPPED = Path(__file__).parents[1] / "kernels.pack"
"""A wheel's own, which whoever may change it could change this module as well."""


class PackError(ValueError):
    """A pack that is not run, and why."""


class Pack(Store):
    """Kernels, and states in which presets begin, as one file, for machines with the same Python, Numba and kind of
    processor. It is read into memory: what becomes of the file later changes nothing.

    Its first line is `MAGIC`, then come the hash of all that follows as a line, and a zip file (`unzip -l` lists it)
    with `MANIFEST`, which says what the kernels were compiled with, and the cache's entries. The hash tells damage, an
    owner who alone can write it says whose word it is. Names are looked up and never become paths.
    """

    made: dict[str, Any]

    def __init__(self, path: Path) -> None:
        """Raises `OSError`, and `PackError` where it is not whole or more than its owner may change it."""
        super().__init__(path)
        try:
            self._zip = zipfile.ZipFile(io.BytesIO(_checked(_content(path))))
            found = {one.filename: one for one in self._zip.infolist()}
            if len(found) != len(self._zip.infolist()) or sum(one.file_size for one in found.values()) > MOST_BYTES:
                raise PackError("it holds a name twice, or too much")
            self.made = json.loads(self._zip.read(found.pop(MANIFEST)))
            for name in found:
                if not ENTRY.fullmatch(name):
                    raise PackError(f"it holds {name!r}, which is no kernel's name")
            if not all(isinstance(self.made[key], dict) for key in ("with", "processor", "sources")):
                raise PackError(f"its {MANIFEST} is not what strandcli writes")
        except (PackError, OSError):
            raise
        except Exception as error:  # of zipfile and json there are a dozen
            raise PackError(f"it is no pack: {type(error).__name__}") from None
        self._entries = found

    def __len__(self) -> int:
        """Number of its kernels."""
        return sum(name.endswith(".kernel") for name in self._entries)

    @contextlib.contextmanager
    def opened(self, name: str) -> Iterator[BinaryIO]:
        if name not in self._entries:
            raise FileNotFoundError(name)
        yield io.BytesIO(self._zip.read(self._entries[name]))


def packed(made: Mapping[str, Any], entries: Mapping[str, bytes]) -> bytes:
    """The content of a pack of these kernels, with what they were compiled with; the same kernels make the same."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as out:
        for name, data in {MANIFEST: json.dumps(made, indent=1, sort_keys=True).encode(), **entries}.items():
            out.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED, 9)
    return MAGIC + _hash(content.getvalue()) + content.getvalue()


def _hash(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode() + b"\n"


def _content(path: Path) -> bytes:
    """The bytes of a pack's file, whoever owns it if no other user may change it. Raises `OSError`, `PackError`."""
    with open(os.open(path, READ), "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode) or status.st_size > MOST_BYTES:
            raise PackError("it is no file, or too large")
        if path != SHIPPED and (writable_by := writers(status, status.st_uid)):
            raise PackError(f"{writable_by}: 'chmod go-w {path}' where it is yours")
        return file.read()


def _checked(data: bytes) -> bytes:
    """The zip file of a pack."""
    if not data.startswith(MAGIC):
        raise PackError("it is no pack")
    end = len(MAGIC) + 65
    if data[len(MAGIC) : end] != _hash(data[end:]):
        raise PackError("its content is not what was written: it is damaged, or cut short")
    return data[end:]
