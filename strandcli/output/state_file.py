"""Files of arrays. `write_array` writes one that NumPy reads, with a fingerprint as the comment; `write_state`
a file of named arrays, checked by a hash, for a reader that knows their types and shapes: nothing is unpickled.

``strandcli state 1``, a line of JSON (who wrote it, and name, type and shape of each array), the arrays' bytes one
after the other, little-endian, and 32 bytes of SHA-256 of all that. Line and arrays are filled up to multiples of 64
bytes.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
from numpy.typing import NDArray

from ..files.inputs import READ
from .files import atomic

MAGIC = b"strandcli state 1\n"
LONGEST_HEAD = 1 << 16
"""Bytes of the line of JSON."""
FREE = "free "
"""Begin of the names of arrays along one axis whose length the file tells."""
DIGEST = hashlib.sha256().digest_size
UNIT = 64
"""Bytes of which arrays begin at multiples."""

Arrays = Mapping[str, NDArray[Any]]


class DamagedError(Exception):
    """A file is not what was written."""


class ForeignError(Exception):
    """A file is whole, and of something else."""


def write_state(path: Path, key: str, arrays: Arrays) -> None:
    """Write arrays under a key, whole or not at all. Raises `RefusedError`."""
    with atomic(path) as file:
        file.writelines(state_pieces(key, arrays))


def state_pieces(key: str, arrays: Arrays) -> Iterator[bytes | memoryview]:
    """Yield the content of such a file, an array at a time; of those that are contiguous nothing is copied."""
    whole = hashlib.sha256()
    kinds = [[name, _type(one), list(one.shape)] for name, one in arrays.items()]
    head = json.dumps({"key": key, "arrays": kinds}).encode()
    yield from _noted(whole, MAGIC + head + b" " * (-(len(MAGIC) + len(head) + 1) % UNIT) + b"\n")
    for one in arrays.values():
        flat: Any = np.ascontiguousarray(one).reshape(-1)
        yield from _noted(whole, memoryview(flat).cast("B"), bytes(-one.nbytes % UNIT))
    yield whole.digest()


def _noted(whole: Any, *pieces: bytes | memoryview) -> Iterator[bytes | memoryview]:
    for piece in pieces:
        whole.update(piece)
        yield piece


def read_state(path: Path, key: str, arrays: Arrays) -> dict[str, NDArray[Any]]:
    """Return the arrays of a file, with the names, types and shapes of ``arrays``; those `FREE` have any length.

    Raises `ForeignError` where it has another key or other arrays, `DamagedError` where it is not what was written, and
    ``OSError`` where it cannot be read.
    """
    with open(os.open(path, READ), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise DamagedError("it is no file")
        return state_of(file, key, arrays)


def state_of(file: BinaryIO, key: str, arrays: Arrays) -> dict[str, NDArray[Any]]:
    """Return the arrays of an opened file, as `read_state`: parts of one piece of memory, as large as the file."""
    whole: Any = np.empty(file.seek(0, os.SEEK_END), np.uint8)
    file.seek(0)
    content = whole[:-DIGEST]
    if file.readinto(whole) != whole.nbytes or whole[: len(MAGIC)].tobytes() != MAGIC:  # type: ignore[attr-defined]
        raise DamagedError("it does not begin as one")
    if hashlib.sha256(content).digest() != whole[-DIGEST:].tobytes():
        raise DamagedError("its content is not what was written")
    line = content[len(MAGIC) : LONGEST_HEAD].tobytes().partition(b"\n")[0]
    place, read = len(MAGIC) + len(line) + 1, {}
    try:
        head = json.loads(line)
        shapes = {name: shape for name, _, shape in head["arrays"]}
        if head["key"] != key or not _fits(head["arrays"], arrays):
            raise ForeignError
        for name, one in arrays.items():
            size = one.itemsize * int(np.prod(shapes[name], dtype=np.int64))
            read[name] = content[place : place + size].view(one.dtype).reshape(shapes[name])
            place += size + -size % UNIT
    except (ValueError, TypeError, KeyError, RecursionError):
        raise DamagedError("its head is damaged") from None
    return read


def _fits(found: list[Any], arrays: Arrays) -> bool:
    """Whether names, types and shapes are those of ``arrays``, but for the lengths of those that are `FREE`."""
    wanted = [[name, _type(one), list(one.shape)] for name, one in arrays.items()]
    return [one[:2] for one in found] == [one[:2] for one in wanted] and all(
        shape == asked or (name.startswith(FREE) and len(shape) == 1 and shape[0] >= 0)
        for (name, _, shape), (*_, asked) in zip(found, wanted, strict=True)
    )


def _type(array: NDArray[Any]) -> str:
    return array.dtype.newbyteorder("<").str


MARK = b"strandcli of "


def write_array(path: Path, name: str, array: npt.NDArray[np.generic], of: str = "", packed: bool = False) -> None:
    """Write an array, whole or not at all, with the fingerprint that it is ``of``. Raises `RefusedError`."""
    kind = zipfile.ZIP_DEFLATED if packed else zipfile.ZIP_STORED
    with atomic(path) as file, zipfile.ZipFile(file, "w", kind, compresslevel=1) as archive:
        with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
            np.lib.format.write_array(member, np.ascontiguousarray(array), allow_pickle=False)
        if of:
            archive.comment = MARK + of.encode()


def made_of(archive: zipfile.ZipFile) -> str:
    """The fingerprint that an archive is of; empty where it has none."""
    comment = archive.comment
    return comment.removeprefix(MARK).decode("ascii", "replace") if comment.startswith(MARK) else ""
