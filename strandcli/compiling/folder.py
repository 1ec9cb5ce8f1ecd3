"""The folder that holds compiled kernels and generated modules.

``STRANDCLI_CACHE_DIR`` names it, else the user's cache folder. What lies around it may be anybody's: nothing is removed
there but files that strandcli has named. Nobody but the user and root may be able to change the folder or its files,
for they are run as code. One that cannot be written, such as that of an image, is read, and what is not there is
compiled into a temporary one. ``STRANDCLI_CACHE_PATH`` lists folders and packs that are read after it, whoever owns
them.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import hashlib
import importlib.util
import os
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, BinaryIO

from .. import __version__
from .stores import DAY, SHIPPED, FolderStore, Pack, PackError, Store, T, writers

KEPT_DAYS = 30.0
"""An entry that no run has loaded for so long is removed."""
MOST_BYTES = 1 << 30
"""Beyond this the entries that were not loaded for longest are removed."""
PART_SECONDS = 600.0
"""A file being written is renamed within milliseconds; one this old was left by a process that was killed."""
ENTRY = re.compile(r"[\w.<>]+-[0-9a-f]{24}\.(kernel|arrays)|[a-z_]+_[0-9a-f]{16}\.py")
PART = re.compile(r"\d+-\w+\.part")
OLD_FOLDER = re.compile(r"kernels-\d+\.\d+\.\w+")
"""Folders of other versions."""
SWEPT = "swept"


class Folder:
    """Chosen when it is first asked for."""

    def __init__(self) -> None:
        self._path: Path | None = None
        self._trouble: str | None = None
        self._read_only: list[Store] = []
        self._refused: list[str] = []
        self._reported: set[str] = set()
        self.arrays = True
        """Whether arrays are read, or all are computed, as in a new home."""
        self.warn: Callable[[str], None] | None = None
        """Is handed, once, each line on what keeps kernels from being stored or read."""

    @property
    def path(self) -> Path:
        """A private folder of this user, into which is written; a temporary one of this process where that cannot be
        written, or other users can write there."""
        if self._path is None:
            self._path = self._choose()
            listed = os.environ.get("STRANDCLI_CACHE_PATH", "").split(os.pathsep)
            self._read_only += self._opened([*filter(None, listed), *([str(SHIPPED)] if SHIPPED.exists() else [])])
        return self._path

    @property
    def trouble(self) -> str | None:
        """One line: what keeps kernels from being stored for the next run, and what to do; None without."""
        _ = self.path
        return self._trouble

    @property
    def read_only(self) -> Sequence[Store]:
        """Folders and packs that are read and not written, in this order, after the folder of `path`."""
        _ = self.path
        return self._read_only

    @property
    def refused(self) -> Sequence[str]:
        """A line for each folder and pack that was to be read and is not, or not all of it."""
        _ = self.path
        return self._refused

    @property
    def stores(self) -> Sequence[Store]:
        """All that is read, in this order."""
        return [FolderStore(self.path), *self.read_only]

    @property
    def keeps_nothing(self) -> str | None:
        """The `trouble` where nothing is read either."""
        return None if self.read_only else self.trouble

    def use(self, path: Path, read_only: Sequence[str] = ()) -> None:
        """Take these, which another process has chosen."""
        self._path, self._read_only = path, self._opened(read_only)

    def find(self, name: str) -> Path:
        """Where a file is in a folder that is read; where it would be written if there is none."""
        places = [one.path / name for one in self.stores]
        return next((one for one in places if os.path.exists(one)), places[0])

    def load(self, name: str, read: Callable[[BinaryIO], T]) -> T | None:
        """What ``read`` makes of the first sound entry of a name; None where there is none."""
        found = (one.load(name, read) for one in self.stores)
        return next((one for one in found if one is not None), None)

    def missed(self) -> None:
        """Tell `warn` why a kernel that is compiled may not have been found."""
        found = [*self.refused, *(one.damage for one in self.read_only), self.trouble if self.read_only else None]
        for words in filter(None, found):
            self.tell(words)

    def refuse(self, store: Store, why: str, whole: bool = True) -> None:
        """Note, once, that a store is not read, or, unless ``whole``, not all of it."""
        if not any(one.startswith(f"{store.path}: ") for one in self._refused):
            self._refused.append(f"{store.path}: {why}: kernels are compiled instead")
        if whole:
            self._read_only.remove(store)

    def tell(self, words: str) -> None:
        """Hand a line to `warn`, once."""
        if self.warn is not None and words not in self._reported:
            self._reported.add(words)
            self.warn(words)

    def _opened(self, paths: Iterable[str]) -> list[Store]:
        """Folders and packs that other users may own, but for those that are refused."""
        found: list[Store] = []
        for path in (Path(one).absolute() for one in paths):
            try:
                found.append(_read_only(path))
            except (OSError, PackError) as error:
                why = error.strerror if isinstance(error, OSError) and error.strerror else error
                self._refused.append(f"{path}: is not run ({why}): kernels are compiled instead")
        return found

    def write(self, path: Path, content: bytes | Iterable[bytes | memoryview]) -> bool:
        """Write a file of this folder, whole or not at all, of bytes or pieces; returns whether it is there.

        The first failure is reported to `warn`; no failure is raised.
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
                self.tell(self._trouble)
            return False

    def _choose(self) -> Path:
        import platformdirs

        chosen = os.environ.get("STRANDCLI_CACHE_DIR")
        base = Path(chosen) if chosen else Path(platformdirs.user_cache_dir("strandcli", appauthor=False))
        folder = base / f"kernels-{__version__}"
        try:
            if not folder.is_dir():
                base.mkdir(mode=0o700, parents=True, exist_ok=True)
                folder.mkdir(mode=0o700, exist_ok=True)
            writable_by = writers(folder.stat())
            if not writable_by and _is_writable(folder):
                with contextlib.suppress(OSError):
                    os.utime(folder)
                    sweep(base, folder)
                return folder
            if writable_by:
                self._trouble = (
                    f"{folder}: kernels that lie there are not run, for {writable_by}: every run will compile anew; "
                    f"'chmod go-w {folder}' where it is yours, or point STRANDCLI_CACHE_DIR at a folder of your own"
                )
            else:
                with os.scandir(folder):  # which needs the right to read it
                    self._read_only.append(FolderStore(folder))
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


def module_of(text: str, prefix: str, folder: Path) -> Any:
    """A module with this text, which strandcli writes for a scene, named by the prefix and the text's hash; its file is
    made in ``folder`` unless it is there."""
    name = f"{prefix}_{text_hash(text.encode())}"
    path = folder / f"{name}.py"
    try:
        known = path.is_file() and path.read_bytes() == text.encode()  # bytes: a damaged file need not be text
    except OSError:
        known = False
    known = known or cache.write(path, text.encode())
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    module: Any = importlib.util.module_from_spec(spec)
    if not known:
        module.__strandcli_text__ = text.encode()  # the key of its kernels follows from it
    sys.modules[name] = module  # a cached kernel imports its module by name when it is loaded
    exec(compile(text, path, "exec"), module.__dict__)  # not by the loader, whom damaged bytecode beside it would stop
    return module


def _read_only(path: Path) -> Store:
    """A folder or pack that only its owner may change. Raises `OSError`, and `PackError` where it is refused."""
    if not path.is_dir():
        return Pack(path)
    inner = path / f"kernels-{__version__}"
    path = inner if inner.is_dir() else path
    found = path.stat()
    if writable_by := writers(found, found.st_uid):
        raise PackError(f"{writable_by}: 'chmod go-w {path}' where it is yours")
    with os.scandir(path):  # which needs the right to read it
        return FolderStore(path, getattr(found, "st_uid", None))


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
