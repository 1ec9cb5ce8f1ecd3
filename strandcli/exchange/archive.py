"""Arrays of an .npz file, told apart by their headers before any is read."""

from __future__ import annotations

import math
import sys
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import UsageError, said
from ..output.files import ARCHIVE_ERRORS
from .bounded import Bounded, amount

METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
LARGEST_DIRECTORY = 1 << 20
"""Bytes of an archive's list of members: one of a thousand arrays has a twentieth of it."""
SPARE = 1 << 26
"""Bytes that arrays may take beyond three times the file: packed ones may be of any size."""
HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
"""Readers of headers, by their version; later ones are of records."""
DAMAGED = (*ARCHIVE_ERRORS, UserWarning)
"""What a damaged array or archive raises."""


@dataclass(frozen=True, slots=True)
class Member:
    """An array that could be read: its name, byte of its entry, type and shape."""

    name: str
    info: zipfile.ZipInfo
    kind: np.dtype[Any]
    shape: tuple[int, ...]


def array_header(file: Any) -> tuple[np.dtype[Any], tuple[int, ...], bool] | None:
    """Type and shape of an array of numbers or text as numpy writes it, and whether it is in Fortran's order; None for
    one of anything else. Raises `DAMAGED`."""
    version = np.lib.format.read_magic(file)
    if version not in HEADERS:
        return None
    shape, fortran, kind = HEADERS[version](file)
    return (kind, shape, fortran) if kind.kind in "iuU" or (kind.kind == "f" and kind.itemsize <= 8) else None


class Archive:
    """The arrays of a file by name, and how many bytes may still be taken for them."""

    def __init__(self, file: Bounded, archive: zipfile.ZipFile) -> None:
        """Read the headers of all arrays; ``members`` are of numbers, ``texts`` of text, others are left out."""
        self.file, self.archive = file, archive
        self.room = 2 * file.size + SPARE
        self.members: dict[str, Member] = {}
        self.texts: dict[str, Member] = {}
        for info in archive.infolist():
            if info.filename.endswith(".npy"):
                found = self._member(info)
                if found is not None:
                    (self.texts if found.kind.kind == "U" else self.members)[found.name] = found

    def fault(self, info: zipfile.ZipInfo, message: str) -> UsageError:
        """An error about a member."""
        return self.file.fault(f"{info.filename}: {message}", info.header_offset)

    def _member(self, info: zipfile.ZipInfo) -> Member | None:
        if info.flag_bits & 1:
            raise self.fault(info, "is encrypted; unpack it and pack it again without a password")
        if info.compress_type not in METHODS:
            raise self.fault(info, f"is packed by method {info.compress_type}; pack it with numpy.savez_compressed")
        with self.opened(info) as member:
            header = array_header(member)
            begin = member.tell()
        if header is None:
            return None
        kind, shape, _ = header
        needs = math.prod(shape) * kind.itemsize
        if begin + needs != info.file_size:
            raise self.fault(
                info, f"shape {shape} of {kind} needs {amount(needs)}, the archive lists "
                f"{amount(max(0, info.file_size - begin))}; it is damaged",
            )  # fmt: skip
        if info.compress_type == zipfile.ZIP_STORED and info.file_size > self.file.size:
            raise self.fault(info, f"{amount(info.file_size)} unpacked, the file has {amount(self.file.size)}")
        return Member(info.filename.removesuffix(".npy"), info, kind, shape)

    def read(self, member: Member) -> npt.NDArray[Any]:
        """An array: single precision of all floating-point types, integers and texts as they are."""
        kind = np.dtype("f4") if member.kind.kind == "f" else member.kind.newbyteorder("=")
        size = math.prod(member.shape)
        if size * kind.itemsize > self.room:
            raise self.fault(
                member.info, f"{amount(size * kind.itemsize)} unpacked, {amount(self.file.size)} packed: more than is "
                "believed; unpack it with numpy and write it with numpy.savez",
            )  # fmt: skip
        self.room -= size * kind.itemsize
        with self.opened(member.info) as file, np.errstate(over="ignore", invalid="ignore"):
            values = np.lib.format.read_array(file, allow_pickle=False)
            if file.read(1):
                raise self.fault(member.info, "continues after its numbers; it is damaged")
            return np.ascontiguousarray(values, kind)

    def text(self, member: Member) -> tuple[str, ...]:
        """The texts of an array. Raises `UsageError` where they are none."""
        values = self.read(member).reshape(-1)
        letters = values.view(np.uint32) if values.nbytes else np.zeros(0, np.uint32)
        if letters.size and int(letters.max()) > sys.maxunicode:
            raise self.fault(member.info, "is no text; it is damaged")
        return tuple(values.tolist())

    @contextmanager
    def opened(self, info: zipfile.ZipInfo) -> Iterator[Any]:
        """A member to be read. Whatever a damaged archive raises becomes a `UsageError`."""
        try:
            with self.archive.open(info) as member:
                yield member
        except DAMAGED as error:
            raise self.fault(info, f"cannot be read: {said(error)}; it is damaged") from None


@contextmanager
def arrays_of(file: Bounded) -> Iterator[Archive]:
    """The arrays of a file. Raises `UsageError` where it is no archive of arrays."""
    _check_directory(file)
    try:
        archive = zipfile.ZipFile(file.file)
    except ARCHIVE_ERRORS as error:
        raise file.damaged(f"archive: {error}", 0) from None
    with archive:
        yield Archive(file, archive)


def _check_directory(file: Bounded) -> None:
    """Raise where the list of members is too long to be one of arrays: zipfile would read all of it."""
    tail = min(file.size, 22 + 65_535 + 76)
    file.seek("end of the archive", file.size - tail)
    data = file.take("end of the archive", tail)
    at = len(data) - 22 if data[-22:-18] == b"PK\5\6" and data[-2:] == b"\0\0" else data.rfind(b"PK\5\6")
    if at < 0 or at + 22 > len(data):
        raise file.damaged("has no list of members at its end", 0)
    size = int.from_bytes(data[at + 12 : at + 16], "little")
    if at >= 76 and data[at - 20 : at - 16] == b"PK\6\7":
        size = int.from_bytes(data[at - 36 : at - 28], "little")
    if size > LARGEST_DIRECTORY:
        raise file.damaged(f"list of members: {amount(size)}", file.size - tail + at + 12)
