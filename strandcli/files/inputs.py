"""Files that scenes are read from. All are opened here, so that what is made of them, and the fingerprints of frames,
know by content every file that they follow from, those that a file names too, and those that were not there.

A file is known by its stamp, numbers that writing it changes: no program can set the time of the last change of its
status. It counts whole ticks of the file system's clock, though, so a file that was written within the last tick is
known by its content alone.
"""

from __future__ import annotations

import functools
import os
import stat
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, TypeVar, cast

from ..errors import RefusedError, UsageError
from .numbered import is_numbered, numbered

READ = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
"""Flags of `os.open` for files that may be pipes or devices: without waiting for who writes. Windows has neither of the
first two, and would change ends of lines without the last."""
TICK, COARSE = 50_000_000, 2_000_000_000
"""Nanoseconds that clocks of file systems count at most: FAT two seconds, those that know parts of one 10 ms."""
LARGEST = 1 << 31
"""Bytes of a file that is read whole."""

Stamp = tuple[int, ...]
Made = TypeVar("Made", bound=Callable[..., Any])


class Input(NamedTuple):
    """A file as it was when it was opened."""

    path: str
    stamp: Stamp
    """Device, number, size, and nanoseconds of its last changes; of a pipe or a folder its kind; of a path that stands
    for numbered files their numbers; of nothing empty."""
    digest: str
    """Of its content; empty where the stamp tells enough."""


class _Thread(threading.local):
    """The recordings under way in a thread, innermost last."""

    def __init__(self) -> None:
        self.recordings: list[dict[Input, None]] = []


_thread = _Thread()
_digests: dict[tuple[str, Stamp], str] = {}
"""Of files that no tick hides a change of."""
_named: dict[str, tuple[Input, ...]] = {}
"""By path what was opened when that file was read: itself, and what it names."""


@contextmanager
def opened(path: Path | str) -> Iterator[BinaryIO]:
    """A file to be read, at its begin. Raises `UsageError` for what is no file and for one that is written meanwhile,
    and `RefusedError` for one that may not be read."""
    try:
        descriptor = os.open(path, READ)
    except FileNotFoundError:
        _record(Input(_absolute(path), (), ""))
        raise UsageError(f"{path}: no such file") from None
    except PermissionError:
        raise RefusedError(f"{path}: no permission to read it") from None
    except (OSError, ValueError) as error:
        raise UsageError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    found = os.fstat(descriptor)
    if not stat.S_ISREG(found.st_mode):
        os.close(descriptor)
        _record(Input(_absolute(path), _stamp(found), ""))
        kind = "a folder" if stat.S_ISDIR(found.st_mode) else "no file but a pipe or a device"
        raise UsageError(f"{path}: is {kind}")
    with open(descriptor, "rb") as file:
        if _thread.recordings:
            _record(_input(_absolute(path), found, file))
        yield file
        now = os.fstat(descriptor)
        if (now.st_size, now.st_mtime_ns) != (found.st_size, found.st_mtime_ns):
            raise UsageError(f"{path}: was written while it was read; read it again when it is written")


def content(path: Path | str, most: int = LARGEST) -> bytes:
    """What a file holds. Raises as `opened`, and `UsageError` for more than ``most`` bytes."""
    with opened(path) as file:
        data = file.read(min(os.fstat(file.fileno()).st_size, most) + 1)
    if len(data) > most:
        raise UsageError(f"{path}: is larger than {most / 1e6:,.0f} MB")
    return data


def note(path: Path | str) -> None:
    """Record a file that another process, or a library, reads by itself."""
    if _thread.recordings:
        _record(_now(_absolute(path)))


@contextmanager
def recording() -> Iterator[dict[Input, None]]:
    """Files that this thread opens meanwhile, in their order; also where that ends in an error."""
    found: dict[Input, None] = {}
    _thread.recordings.append(found)
    try:
        yield found
    finally:
        _thread.recordings.pop()
        for one in found:
            _record(one)


@contextmanager
def unrecorded() -> Iterator[None]:
    """Keep what is opened meanwhile, results of an earlier run, out of all recordings."""
    recordings, _thread.recordings = _thread.recordings, []
    try:
        yield
    finally:
        _thread.recordings = recordings


def changed() -> str | None:
    """What is to be said of files of the innermost recording that have another content than when they were opened;
    None where there is none."""
    found = list(dict.fromkeys(one.path for one in _thread.recordings[-1] if not is_current(one)))
    if not found:
        return None
    more = f" and {len(found) - 1:,} more" if len(found) > 1 else ""
    return f"{found[0]}{more}: written after it had been read, so results may be of either; run again to have the new"


@contextmanager
def reading(path: Path | str) -> Iterator[None]:
    """Remember what is opened meanwhile as what a file names."""
    with recording() as found:
        yield
    _named[_absolute(path)] = tuple(found)


def inputs_of(path: Path | str, read: Callable[[], object]) -> tuple[Input, ...]:
    """The files that reading a file opens, as they are now; ``read`` reads it, where that has not been done yet."""
    with recording() as found:
        known = _named.get(_absolute(path), ())
        if known and all(map(is_current, known)):
            for one in known:
                _record(one)
        else:
            read()
    return tuple(found)


def is_current(one: Input) -> bool:
    """Whether a file has the content that it had."""
    now = _stamp_of(one.path)
    if now == one.stamp and not one.digest:
        return True
    known = one.digest or _digests.get((one.path, one.stamp), "")
    if not now or not known:
        return False
    return known == (_digests.get((one.path, now)) or _now(one.path, digest=True).digest)


def digest_of(one: Input) -> str:
    """Hash of what a file had when it was opened, 32 hexadecimal digits; empty where there was none. Raises
    `UsageError` where it has changed since."""
    known = one.digest or _digests.get((one.path, one.stamp), "")
    if known or not one.stamp:
        return known
    now = _now(one.path, digest=True)
    if now.stamp != one.stamp:
        raise UsageError(f"{one.path}: was written after it had been read; run again when it is written")
    return now.digest


def cached(most: int) -> Callable[[Made], Made]:
    """Decorator: results for the last ``most`` arguments are cached as long as the files that they were read from are
    the same."""

    def decorate(make: Made) -> Made:
        results: OrderedDict[Hashable, tuple[Any, tuple[Input, ...]]] = OrderedDict()
        lock = threading.Lock()

        @functools.wraps(make)
        def result(*given: Hashable) -> Any:
            given_here = _folder(), given  # paths among the arguments may be relative
            with lock:
                value, inputs = results.get(given_here, (None, None))
            if inputs is not None and all(map(is_current, inputs)):
                for one in inputs:
                    _record(one)
            else:
                with recording() as found:
                    value = make(*given)
                inputs = tuple(found)
            with lock:
                results[given_here] = value, inputs
                results.move_to_end(given_here)
                if len(results) > most:
                    results.popitem(last=False)
            return value

        return cast(Made, result)

    return decorate


def _record(one: Input) -> None:
    if _thread.recordings:
        _thread.recordings[-1][one] = None


def _folder() -> str:
    """The working folder; nothing where it is gone."""
    try:
        return os.getcwd()
    except OSError:
        return ""


def _absolute(path: Path | str) -> str:
    try:
        return os.path.abspath(path)
    except OSError:  # the folder that this process is in is gone, and nothing is found from it
        return os.fspath(path)


def _stamp_of(path: str) -> Stamp:
    try:
        return _stamp(os.stat(path))
    except (OSError, ValueError):
        return _numbers(path)


def _numbers(path: str) -> Stamp:
    return tuple(numbered(Path(path))) if is_numbered(path) else ()


def _stamp(found: os.stat_result) -> Stamp:
    if not stat.S_ISREG(found.st_mode):
        return (found.st_mode,)
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns


def _input(path: str, found: os.stat_result, file: BinaryIO, digest: bool = False) -> Input:
    """A file that is open at its begin, with its digest where it is asked for or a change might have no other sign."""
    stamp = _stamp(found)
    last = found.st_ctime_ns if os.name == "posix" else max(found.st_mtime_ns, found.st_ctime_ns)
    settled = time.time_ns() - last > (TICK if last % 1_000_000_000 else COARSE)
    if settled and not digest:
        return Input(path, stamp, "")
    known = _digests.get((path, stamp), "") if settled else ""
    if not known:
        import hashlib  # which a command that reads nothing does without

        known = hashlib.file_digest(cast(Any, file), "blake2b").hexdigest()[:32]
        file.seek(0)
    if settled:
        _digests[path, stamp] = known
    return Input(path, stamp, known)


def _now(path: str, digest: bool = False) -> Input:
    """A file, or numbered ones, as they are now; without a stamp where there is none that can be read."""
    try:
        descriptor = os.open(path, READ)
        found = os.fstat(descriptor)
        if not stat.S_ISREG(found.st_mode):
            os.close(descriptor)
            return Input(path, _stamp(found), "")
        with open(descriptor, "rb") as file:
            return _input(path, found, file, digest)
    except (OSError, ValueError):
        return Input(path, _numbers(path), "")
