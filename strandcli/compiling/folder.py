"""The folder that holds compiled kernels and generated modules.

``STRANDCLI_CACHE_DIR`` names it, else the user's cache folder. What lies around it may be anybody's: nothing is removed
there but files that strandcli has named. Nobody but the user and root may be able to change the folder or its files,
for they are run as code. One that cannot be written, such as that of an image, is read, and what is not there is
compiled into a temporary one.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import hashlib
import os
import re
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import BinaryIO

from .. import __version__
from ..opening import READ

DAY = 86_400.0
KEPT_DAYS = 30.0
"""An entry that no run has loaded for so long is removed."""
MOST_BYTES = 1 << 30
"""Beyond this the entries that were not loaded for longest are removed."""
PART_SECONDS = 600.0
"""A file being written is renamed within milliseconds; one this old was left by a process that was killed."""
ENTRY = re.compile(r"[\w.<>]+-[0-9a-f]{24}\.(kernel|arrays)|[a-z_]+_[0-9a-f]{16}\.py")
PART = re.compile(r"\d+-\w+\.part")
OLD_FOLDER = re.compile(r"kernels-\d+\.\d+\.\w+|\d+\.\d+\.\w+-[0-9a-f]{12}")
"""Folders of other versions, and of those whose folder's name held a hash of all sources."""
SWEPT = "swept"
ROOT = 0
"""The user who may change everything anyway."""


class Folder:
    """Chosen when it is first asked for."""

    def __init__(self) -> None:
        self._path: Path | None = None
        self._trouble: str | None = None
        self._shared: Path | None = None
        self._told = False
        self.warn: Callable[[str], None] | None = None
        """Is handed, once, what keeps kernels from being kept."""

    @property
    def path(self) -> Path:
        """A private folder of this user, into which is written; a temporary one of this process where that cannot be
        written, or others can write there."""
        if self._path is None:
            self._path = self._choose()
        return self._path

    @property
    def trouble(self) -> str | None:
        """One line: what keeps kernels from being kept for the next run, and what to do; None where they are kept."""
        _ = self.path
        return self._trouble

    @property
    def shared(self) -> Path | None:
        """The folder that is read and cannot be written; None where there is no such."""
        _ = self.path
        return self._shared

    def use(self, path: Path, shared: Path | None = None) -> None:
        """Take these folders, which another process has chosen."""
        self._path, self._shared = path, shared

    def find(self, name: str) -> Path:
        """Where a file is that was written here or lies in the shared folder; where it would be written if there is
        none."""
        path = self.path / name
        if self._shared is None or os.path.exists(path):
            return path
        there = self._shared / name
        return there if os.path.exists(there) else path

    def missed(self) -> None:
        """Tell `warn`, once, that a kernel is compiled which the shared folder does not have."""
        if self.shared is not None:
            self._tell()

    def _tell(self) -> None:
        if self.warn is not None and not self._told and self._trouble is not None:
            self._told = True
            self.warn(self._trouble)

    def write(self, path: Path, content: bytes | Iterable[bytes | memoryview]) -> bool:
        """Write a file of this folder, whole or not at all, of bytes or pieces; returns whether it is there.

        The first failure is told to `warn`; no failure is raised.
        """
        temporary = None
        try:
            handle, name = tempfile.mkstemp(dir=path.parent, prefix=f"{os.getpid()}-", suffix=".part")
            temporary = Path(name)
            with open(handle, "wb") as out:
                out.writelines([content] if isinstance(content, bytes) else content)
            os.replace(temporary, path)
            return True
        except OSError as error:
            if temporary is not None:
                with contextlib.suppress(OSError):
                    temporary.unlink()
            if self._trouble is None:
                self._trouble = _advice(path.parent, error)
                self._tell()
            return False

    def discard(self, path: Path) -> None:
        """Remove an entry that is not what was written, if that can be done; a folder in its place if it is empty."""
        for remove in (os.unlink, os.rmdir):
            with contextlib.suppress(OSError):
                remove(path)
                return

    def _choose(self) -> Path:
        import platformdirs

        chosen = os.environ.get("STRANDCLI_CACHE_DIR")
        base = Path(chosen) if chosen else Path(platformdirs.user_cache_dir("strandcli", appauthor=False))
        folder = base / f"kernels-{__version__}"
        try:
            if not folder.is_dir():
                base.mkdir(mode=0o700, parents=True, exist_ok=True)
                folder.mkdir(mode=0o700, exist_ok=True)
            others = writers(folder.stat())
            if not others and _is_writable(folder):
                with contextlib.suppress(OSError):
                    os.utime(folder)
                    sweep(base, folder)
                return folder
            if others:
                self._trouble = (
                    f"{folder}: kernels that lie there are not run, for {others}: every run will compile anew; "
                    f"'chmod go-w {folder}' where it is yours, or point STRANDCLI_CACHE_DIR at a folder of your own"
                )
            else:
                with os.scandir(folder):  # which needs the right to read it
                    self._shared = folder
                self._trouble = (
                    f"{folder}: is read and cannot be written: kernels that are not there, or that others may change, "
                    "are compiled anew in every run; have who may write there run 'strandcli warmup', or point "
                    "STRANDCLI_CACHE_DIR elsewhere"
                )
        except OSError as error:
            self._trouble = _advice(folder, error)
        try:
            folder = Path(tempfile.mkdtemp(prefix="strandcli-"))
            atexit.register(shutil.rmtree, folder, ignore_errors=True)
        except OSError:  # nothing can be written anywhere: every kernel is compiled in this process
            pass
        return folder


def text_hash(text: bytes) -> str:
    """The end of the name of a module that strandcli writes there: 16 hexadecimal digits of its text's hash."""
    return hashlib.sha256(text).hexdigest()[:16]


def writers(found: os.stat_result) -> str:
    """Who but this user and root may change a folder or a file of the cache, in words; "" where nobody may, and on
    systems that have no such owners."""
    if not hasattr(os, "getuid"):
        return ""
    if found.st_uid not in (os.getuid(), ROOT):
        return "it belongs to another user"
    return "other users may change it" if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else ""


@contextlib.contextmanager
def opened(path: Path) -> Iterator[BinaryIO]:
    """A file of the cache, whose time says at least to the day when it was last used.

    Raises `OSError`, and `ValueError` for what is no file, and for one that others than this user and root may change.
    """
    with open(os.open(path, READ | getattr(os, "O_NOFOLLOW", 0)), "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise ValueError("it is no file")
        if others := writers(status):
            raise ValueError(others)
        if status.st_mtime < time.time() - DAY:
            with contextlib.suppress(OSError):
                os.utime(path)
        yield file


def _is_writable(folder: Path) -> bool:
    """Whether files can be made in a folder. Raises `OSError` where that fails for another reason than rights."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError as error:
        if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
            return False
        raise


def _advice(folder: Path, error: OSError) -> str:
    return (
        f"{folder}: compiled kernels cannot be kept there ({error.strerror or error}): every run will compile "
        "anew; point STRANDCLI_CACHE_DIR at a folder that can be written"
    )


def sweep(base: Path, folder: Path) -> None:
    """Remove files that killed processes have left; once a day also old entries, and folders of old versions."""
    now = time.time()
    daily = _older(folder / SWEPT, now - DAY)
    entries: list[tuple[float, int, str]] = []
    with os.scandir(folder) as found:
        for one in found:
            if PART.fullmatch(one.name):
                if _older(Path(one.path), now - PART_SECONDS):
                    _remove(one.path)
            elif daily and ENTRY.fullmatch(one.name) and one.is_file(follow_symlinks=False):
                status = one.stat(follow_symlinks=False)
                entries.append((status.st_mtime, status.st_size, one.path))
    if not daily:
        return
    (folder / SWEPT).touch()
    size = 0
    for last_use, length, path in sorted(entries, reverse=True):
        size += length
        if last_use < now - KEPT_DAYS * DAY or size > MOST_BYTES:
            _remove(path)
    for other in base.iterdir():
        ours = OLD_FOLDER.fullmatch(other.name) is not None
        if ours and other != folder and other.is_dir() and _older(other, now - KEPT_DAYS * DAY):
            shutil.rmtree(other, ignore_errors=True)


def _older(path: Path, moment: float) -> bool:
    """Whether a file was last changed before a moment; a file that is not there counts as old."""
    try:
        return path.lstat().st_mtime < moment
    except OSError:
        return True


def _remove(path: str) -> None:
    with contextlib.suppress(OSError):
        os.unlink(path)


cache = Folder()
