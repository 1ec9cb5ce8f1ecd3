"""Faults where files are written: each opening, writing, flushing to disk, renaming and making of a folder can fail."""

from __future__ import annotations

import builtins
import errno
import io
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

KINDS = {
    "disk full": errno.ENOSPC, "input/output error": errno.EIO, "no permission": errno.EACCES, "quota": errno.EDQUOT,
}  # fmt: skip
VANISHED = "folder vanished"
OPENING = os.O_WRONLY | os.O_RDWR | os.O_CREAT


class Faults:
    """Counts operations on files under a folder, in their order, and lets one of them fail; with ``sticky`` all that
    come after it, too."""

    def __init__(self, folder: Path, at: int | None = None, kind: str = "", sticky: bool = False) -> None:
        self.folder, self.at, self.kind, self.sticky = str(folder), at, kind, sticky
        self.seen: list[tuple[str, str]] = []
        """What was done and to which file."""
        self.hit: tuple[str, str] | None = None

    def mine(self, path: Any) -> bool:
        return isinstance(path, str | os.PathLike) and os.path.abspath(os.fsdecode(path)).startswith(self.folder + "/")

    def __call__(self, what: str, path: Any) -> None:
        """An operation is about to be carried out: raise what it is to fail with."""
        self.seen.append((what, os.path.abspath(os.fsdecode(path))))
        place = len(self.seen) - 1
        if self.at is None or place < self.at or (place > self.at and not self.sticky):
            return
        self.hit = self.hit or self.seen[place]
        if self.kind == VANISHED:
            shutil.rmtree(os.path.join(self.folder, "out"), ignore_errors=True)
            return
        raise OSError(KINDS[self.kind], os.strerror(KINDS[self.kind]), os.fsdecode(path))


class FaultyFile(io.FileIO):
    """A file whose writes may fail."""

    def __init__(self, faults: Faults, path: Any, mode: str) -> None:
        super().__init__(path, mode)
        self.faults = faults

    def write(self, data: Any) -> int:
        self.faults("write", self.name)
        return super().write(data)


@contextmanager
def injected(faults: Faults) -> Iterator[Faults]:
    """A block in which files under the folder are handled by way of ``faults``, whoever does it in this process."""
    plain = {"open": builtins.open, "os_open": os.open, "replace": os.replace, "mkdir": os.mkdir, "fsync": os.fsync}

    def opened(file: Any, mode: str = "r", buffering: int = -1, *more: Any, **named: Any) -> Any:
        if not faults.mine(file) or not set(mode) & set("wax+"):
            return plain["open"](file, mode, buffering, *more, **named)
        faults("open", file)
        raw = FaultyFile(faults, os.fspath(file), mode.replace("b", "").replace("t", ""))
        binary = io.BufferedRandom(raw) if "+" in mode else io.BufferedWriter(raw)
        return binary if "b" in mode else io.TextIOWrapper(binary, **named)

    def os_opened(path: Any, flags: int, *more: Any, **named: Any) -> int:
        if faults.mine(path) and flags & OPENING:
            faults("open", path)
        found: int = plain["os_open"](path, flags, *more, **named)
        return found

    def renamed(source: Any, target: Any, **named: Any) -> None:
        if faults.mine(target):
            faults("rename", target)
        plain["replace"](source, target, **named)

    def made(path: Any, *more: Any, **named: Any) -> None:
        if faults.mine(path):
            faults("mkdir", path)
        plain["mkdir"](path, *more, **named)

    def flushed(file: Any) -> None:
        try:
            path = os.readlink(f"/proc/self/fd/{file if isinstance(file, int) else file.fileno()}")
        except OSError:
            path = ""
        if faults.mine(path):
            faults("fsync", path)

    with (
        patch.object(builtins, "open", opened), patch.object(io, "open", opened), patch.object(os, "open", os_opened),
        patch.object(os, "replace", renamed), patch.object(os, "rename", renamed), patch.object(os, "mkdir", made),
        patch.object(os, "fsync", flushed),
    ):  # fmt: skip
        yield faults


class Audit:
    """What Python itself says is opened for writing, renamed or made under a folder: to tell whether `injected` has
    seen all of it."""

    _active: Audit | None = None
    _hooked = False

    def __init__(self, folder: Path) -> None:
        self.folder = str(folder)
        self.seen: set[tuple[str, str]] = set()

    def __enter__(self) -> Audit:
        if not Audit._hooked:
            sys.addaudithook(Audit._hear)
            Audit._hooked = True
        Audit._active = self
        return self

    def __exit__(self, *error: object) -> None:
        Audit._active = None

    @staticmethod
    def _hear(event: str, arguments: tuple[Any, ...]) -> None:
        self = Audit._active
        if self is None or event not in ("open", "os.rename", "os.mkdir"):
            return
        path = arguments[1] if event == "os.rename" else arguments[0]
        if not isinstance(path, str | bytes | os.PathLike):
            return
        name = os.path.abspath(os.fsdecode(path))
        if event == "open" and not (arguments[2] or 0) & OPENING:
            return
        if name.startswith(self.folder + "/"):
            self.seen.add(({"open": "open", "os.rename": "rename", "os.mkdir": "mkdir"}[event], name))
