"""Files of arrays. `write_array` writes one that NumPy reads, with a fingerprint as the comment; `write_state`
a file of named arrays, checked by a hash, for a reader that knows their types and shapes: nothing that it says is
believed, no memory is taken on its word, nothing is unpickled.

``strandcli state 1``, a line of JSON (who wrote it, and name, type and shape of each array), the arrays' bytes one
after the other, little-endian, and 32 bytes of SHA-256 of all that.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
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
    pieces: Iterable[bytes | memoryview] = chain((MAGIC, _head(key, arrays)), map(_bytes, arrays.values()))
    for piece in pieces:
        whole.update(piece)
        yield piece
    yield whole.digest()


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
    """Return the arrays of an opened file, as `read_state`."""
    size = os.fstat(file.fileno()).st_size
    magic = file.read(len(MAGIC))
    line = file.readline(LONGEST_HEAD)
    if magic != MAGIC or not line.endswith(b"\n"):
        raise DamagedError("it does not begin as one")
    arrays = _sized(arrays, line, size)
    head = _head(key, arrays)
    if line != head:
        raise ForeignError if _is_head(line) else DamagedError("its head is damaged")
    if size != len(MAGIC) + len(head) + sum(one.nbytes for one in arrays.values()) + DIGEST:
        raise DamagedError("it is not as long as it was written")
    whole = hashlib.sha256(magic + head)
    read: dict[str, NDArray[Any]] = {}
    for name, one in arrays.items():
        read[name] = np.empty(one.shape, one.dtype)
        if file.readinto(_bytes(read[name])) != one.nbytes:  # type: ignore[attr-defined]
            raise DamagedError("it ends too soon")
        whole.update(_bytes(read[name]))
    if file.read(DIGEST + 1) != whole.digest():
        raise DamagedError("its content is not what was written")
    return read


def _bytes(array: NDArray[Any]) -> memoryview:
    flat: Any = np.ascontiguousarray(array).reshape(-1)
    return memoryview(flat).cast("B")


def _head(key: str, arrays: Arrays) -> bytes:
    kinds = [[name, one.dtype.newbyteorder("<").str, list(one.shape)] for name, one in arrays.items()]
    return json.dumps({"key": key, "arrays": kinds}, ensure_ascii=True).encode() + b"\n"


def _sized(arrays: Arrays, line: bytes, most: int) -> Arrays:
    """Return ``arrays``, those that are `FREE` as long as a head tells, up to ``most`` bytes."""
    try:
        shapes = {name: shape for name, _, shape in json.loads(line)["arrays"]}
    except (ValueError, RecursionError, TypeError, KeyError):
        return arrays
    out = dict(arrays)
    for name, one in arrays.items():
        shape = shapes.get(name) if name.startswith(FREE) else None
        if not isinstance(shape, list) or len(shape) != 1 or type(shape[0]) is not int:
            continue
        if 0 <= shape[0] * one.itemsize <= most:
            out[name] = np.empty(shape[0], one.dtype)
    return out


def _is_head(line: bytes) -> bool:
    """Whether a line is that of some file of states; bits that fell over would hardly leave it so."""
    try:
        data = json.loads(line)
    except (ValueError, RecursionError):
        return False
    return isinstance(data, dict) and data.keys() == {"key", "arrays"} and len(str(data["key"])) == KEY


KEY = 64
"""Hexadecimal digits of a key."""


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
