"""Files that are either whole or absent: written under a temporary name in the same folder, then renamed.

A temporary file is named ``.NAME.HOST.PID.tmp``, so that one left by a killed run can be distinguished from one that
another run, perhaps on another machine that shares the folder, is writing just now.
"""

from __future__ import annotations

import errno
import glob
import json
import os
import re
import shutil
import socket
import struct
import time
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

from ..errors import RefusedError, StrandError, UsageError, said
from ..files.inputs import content, unrecorded

_TEMPORARY = re.compile(r"\..+\.(?P<host>[^.]+)\.(?P<pid>[0-9]+)\.tmp(\.\w+)?")
_DAY = 86_400.0
ARCHIVE_ERRORS = (OSError, ValueError, EOFError, zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError,
                  struct.error, OverflowError, SyntaxError, tokenize.TokenError)  # fmt: skip
"""Exceptions that reading a damaged .npz file may raise; an encrypted one raises RuntimeError, and the text of an
array's header is Python's."""


def _host() -> str:
    return re.sub(r"[^A-Za-z0-9_-]", "_", socket.gethostname()) or "host"


def temporary_name(path: Path) -> Path:
    """The name under which this process writes what will become ``path``."""
    return path.with_name(f".{path.name}.{_host()}.{os.getpid()}.tmp")


@contextmanager
def placed(path: Path, suffix: str = "") -> Iterator[Path]:
    """The name under which a block writes what becomes ``path`` when it ends well, and vanishes when it does not: for
    libraries that open files themselves, and want names that end in ``suffix``.

    An ``OSError`` becomes a ``RefusedError`` that says what could not be written and why.
    """
    temporary = temporary_name(path)
    temporary = temporary.with_name(temporary.name + suffix)
    try:
        if path.parent not in _swept:
            _swept.add(path.parent)
            remove_strays(path.parent)
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        _discard_all(temporary)
        raise refusal(error, path) from error
    except BaseException:
        _discard_all(temporary)
        raise


def _discard_all(temporary: Path) -> None:
    """Remove a temporary file, and those that a library which was stopped has begun beside it: ``stem.xxxxxx``."""
    _discard(temporary)
    with suppress(OSError):
        for one in temporary.parent.glob(f"{glob.escape(temporary.stem)}.*"):
            _discard(one)


@contextmanager
def atomic(path: Path) -> Iterator[BinaryIO]:
    """A binary file that takes the name ``path`` when the block ends well, and vanishes when it does not. Raises
    `RefusedError` as `placed` does."""
    with placed(path) as temporary, open(temporary, "wb") as file:
        yield file


BYTES_PER_PIXEL = 1.5
"""Of a frame full of strands, measured as 0.4 to 1.6 (`png`)."""
_CHANNELS = {"tangent": 3, "linear": 4}
_swept: set[Path] = set()
"""Folders where this process has looked for temporary files of killed ones."""


def write_pieces(path: Path, pieces: Iterable[bytes]) -> None:
    """Write ``pieces`` one after the other as the file ``path``, whole or not at all."""
    with atomic(path) as file:
        for piece in pieces:
            file.write(piece)


def write_json(path: Path, data: Any) -> None:
    """Write ``data`` as indented JSON, whole or not at all. NaN and infinities are refused: they are not JSON.

    Bytes of a path that are no text stand there as Python has them, escaped: ``\\udcff``.
    """
    text = json.dumps(data, indent=2, allow_nan=False, ensure_ascii=False)
    write_pieces(path, [text.encode(errors="backslashreplace"), b"\n"])


LARGEST_JSON = 1 << 30
"""Bytes of a JSON file that is read: a report of a million frames has about that."""


@unrecorded()
def read_json(path: Path) -> Any:
    """The data of a JSON file. Raises `UsageError` where there is none, or what is no JSON, too large, or no file but a
    pipe or a device, of which nothing is read, and `RefusedError` where it may not be read."""
    try:
        return json_of(content(path, LARGEST_JSON))
    except ValueError as error:
        raise UsageError(f"{path}: cannot be read: {said(error)}") from None


def json_of(text: bytes) -> Any:
    """The data of JSON. Raises ``ValueError`` for what is none."""
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("nested too deep") from None


def is_own_json(path: Path) -> bool:
    """Whether a file is JSON of strandcli's own, which says its version."""
    with suppress(StrandError, TypeError, ValueError):
        return "strandcli" in dict(read_json(path))
    return False


def require_own(path: Path, own: Callable[[Path], bool] = is_own_json) -> None:
    """``UsageError`` where something is at ``path`` that is no file of strandcli's ``own``."""
    if os.path.lexists(path) and not own(path):
        raise UsageError(
            f"{path}: was not written by strandcli; add --overwrite to replace it, or choose another folder with -o"
        )


def refuse_present(directory: Path, names: Sequence[str]) -> None:
    """``UsageError`` where some files are in the way of a run that may neither replace nor keep them."""
    if names:
        more = f" and {len(names) - 3} more" if len(names) > 3 else ""
        raise UsageError(
            f"{directory}: already has {', '.join(names[:3])}{more}; add --overwrite to replace or --resume to continue"
        )


def _discard(path: Path) -> None:
    with suppress(OSError):
        path.unlink(missing_ok=True)


def refusal(error: OSError, path: Path) -> RefusedError:
    """The one-line error for a file that could not be written."""
    reasons = {
        errno.ENOSPC: "the disk is full; free some space, then run again",
        errno.EDQUOT: "the disk quota is used up; free some space, then run again",
        errno.EFBIG: "the file is larger than this file system or its limits allow",
        errno.EROFS: "the file system is read-only; choose another place",
        errno.EACCES: "no permission to write there; choose another place",
        errno.EPERM: "no permission to write there; choose another place",
        errno.ENAMETOOLONG: "the name is too long",
        errno.ENOTDIR: "a part of this path is a file, not a folder; choose another place",
        errno.EISDIR: "it is a folder",
    }
    reason = reasons.get(error.errno or 0, f"{error.strerror or error}; choose another place")
    return RefusedError(f"{path}: cannot be written: {reason}")


def with_whole(error: RefusedError, finished: Iterable[Path]) -> RefusedError:
    """The same of a run that can be resumed, with how many of its finished files are there."""
    count = count_there(finished)
    whole = f"{count} finished {'frame is' if count == 1 else 'frames are'} whole, --resume skips"
    return RefusedError(f"{error}; {whole} {'it' if count == 1 else 'them'}") if count else error


def count_there(files: Iterable[Path]) -> int:
    """How many of some files are there: a folder may be removed while a run writes into it."""
    return sum(map(os.path.exists, files))


def remove_strays(directory: Path) -> list[Path]:
    """Delete temporary files that killed runs left in ``directory``; returns them.

    A file of this host is a stray when its process is gone; one of another host when it is a day old.
    """
    removed = []
    for path in directory.glob(".*.tmp*"):
        match = _TEMPORARY.fullmatch(path.name)
        if match is None:
            continue
        stray = False
        if match["host"] == _host():
            stray = not _alive(int(match["pid"]))
        else:
            with suppress(OSError):
                stray = time.time() - path.stat().st_mtime > _DAY
        if stray:
            _discard(path)
            removed.append(path)
    return removed


def _alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True
    return True


def prepare_folder(directory: Path, needed_bytes: int) -> None:
    """Make sure that ``directory`` exists, takes files, and has room for ``needed_bytes``; else ``RefusedError``."""
    require_folder(directory, needed_bytes)
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise refusal(error, directory) from error
    remove_strays(directory)


def require_folder(directory: Path, needed_bytes: int) -> None:
    """``RefusedError`` where ``directory``, or that which it would be made in, is no folder, takes no files or has no
    room for ``needed_bytes``. Makes nothing that stays.

    The only sure test of permission is to write, so a file is made and removed.
    """
    place = directory
    try:
        while not place.exists() and place != place.parent:
            place = place.parent
        if not place.is_dir():
            raise RefusedError(f"{place}: is a file, not a folder; choose another folder with -o")
        trial = temporary_name(place / "trial")
        trial.write_bytes(b"")
        trial.unlink()
        free = shutil.disk_usage(place).free
    except OSError as error:
        raise refusal(error, directory) from error
    if free < needed_bytes:
        raise RefusedError(
            f"{directory}: about {megabytes(needed_bytes)} are needed and {megabytes(free)} are free; "
            "free some space or choose another folder with -o"
        )


def megabytes(count: int) -> str:
    """A size for people: ``16 kB``, ``12 MB``, ``3.4 GB``."""
    if count >= 1_000_000_000:
        return f"{count / 1e9:.1f} GB"
    if count >= 1_000_000:
        return f"{round(count / 1e6)} MB"
    return f"{max(1, round(count / 1e3))} kB" if count else "0 kB"


def frame_bytes(pixels: int, layers: Sequence[str] = (), exr: bool = False) -> int:
    """About so many bytes a frame at most: its picture, its layers, and their EXR file."""
    channels = sum(_CHANNELS.get(name, 1) for name in layers)
    return round((BYTES_PER_PIXEL + (10 if exr else 6) * channels) * pixels)
