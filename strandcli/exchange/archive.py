"""Arrays of an .npz file, told apart by their headers before any is read."""

from __future__ import annotations

import math
import re
import sys
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.counted import counted
from ..errors import UsageError, said
from ..output.files import ARCHIVE_ERRORS
from .bounded import SLICE, Bounded, amount

MAGIC = b"\x93NUMPY"
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
LARGEST_DIRECTORY = 1 << 20
"""Bytes of an archive's list of members: one of a thousand arrays has a twentieth of it."""
LONGEST_HEADER = 4096
SPARE = 1 << 26
"""Bytes that arrays may take beyond three times the file: packed ones may be of any size."""
HEADER = re.compile(
    r"\{\s*'descr':\s*'(?P<kind>[<>|=](?:f[248]|[iu][1248]|U\d{1,4}))',\s*'fortran_order':\s*(?P<fortran>True|False),"
    r"\s*'shape':\s*\((?P<shape>(?:\d{1,18},\s*)*(?:\d{1,18})?)\),?\s*\}\s*",
    re.ASCII,
)
"""What numpy writes for arrays of numbers and of text."""


@dataclass(frozen=True, slots=True)
class Member:
    """An array that could be read: its name, byte of its entry, type and shape; ``skip``: bytes before its numbers."""

    name: str
    info: zipfile.ZipInfo
    kind: np.dtype[Any]
    shape: tuple[int, ...]
    fortran: bool
    skip: int

    @property
    def size(self) -> int:
        """How many numbers."""
        return math.prod(self.shape)


def array_header(take: Callable[[int], bytes]) -> tuple[np.dtype[Any], tuple[int, ...], bool, int] | None:
    """Type and shape of an array of numbers as numpy writes it, whether it is in Fortran's order, and bytes before its
    numbers; None for any other content. ``take`` reads so many bytes."""
    begin = take(8)
    if begin[:6] != MAGIC or begin[6] not in (1, 2, 3):
        return None
    width = 2 if begin[6] == 1 else 4
    length = int.from_bytes(take(width), "little")
    match = None if length > LONGEST_HEADER else HEADER.fullmatch(take(length).decode("latin-1"))
    if match is None:
        return None
    shape = tuple(int(one) for one in match["shape"].replace(" ", "").split(",") if one.strip())
    return np.dtype(match["kind"]), shape, match["fortran"] == "True", 8 + width + length


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
            header = array_header(lambda count: _exactly(member, count))
        if header is None:
            return None
        kind, shape, fortran, skip = header
        needs = math.prod(shape) * kind.itemsize
        if skip + needs != info.file_size:
            raise self.fault(
                info, f"shape {shape} of {kind} needs {amount(needs)}, the archive lists "
                f"{amount(max(0, info.file_size - skip))}; it is damaged",
            )  # fmt: skip
        if info.compress_type == zipfile.ZIP_STORED and info.file_size > self.file.size:
            raise self.fault(info, f"{amount(info.file_size)} unpacked, the file has {amount(self.file.size)}")
        return Member(info.filename.removesuffix(".npy"), info, kind, shape, fortran, skip)

    def read(self, member: Member) -> npt.NDArray[Any]:
        """An array: single precision of all floating-point types, integers as they are."""
        kind = np.dtype("f4") if member.kind.kind == "f" else member.kind.newbyteorder("=")
        needs = member.size * kind.itemsize
        if needs > self.room:
            raise self.fault(
                member.info, f"{amount(needs)} unpacked, {amount(self.file.size)} packed: more than is believed; "
                "unpack it with numpy and write it with numpy.savez",
            )  # fmt: skip
        self.room -= needs
        values = np.empty(member.shape, kind)
        flat = values.T.flat if member.fortran else values.reshape(-1)
        with self.opened(member.info) as file, np.errstate(over="ignore", invalid="ignore"):
            _exactly(file, member.skip)
            step = SLICE // member.kind.itemsize
            for begin in range(0, member.size, step):
                count = min(step, member.size - begin)
                part = np.frombuffer(_exactly(file, count * member.kind.itemsize), member.kind)
                flat[begin : begin + count] = part.astype(kind, copy=False)
            if file.read(1):
                raise self.fault(member.info, "continues after its numbers; it is damaged")
        return values

    def text(self, member: Member) -> tuple[str, ...]:
        """The texts of an array. Raises `UsageError` where they are none."""
        letters = self.read(
            replace(
                member,
                kind=np.dtype("u4").newbyteorder(member.kind.byteorder),
                shape=(member.size, member.kind.itemsize // 4),
            )
        )
        if letters.size and int(letters.max()) > sys.maxunicode:
            raise self.fault(member.info, "is no text; it is damaged")
        return tuple("".join(map(chr, row[row > 0].tolist())) for row in letters)

    @contextmanager
    def opened(self, info: zipfile.ZipInfo) -> Iterator[Any]:
        """A member to be read. Whatever a damaged archive raises becomes a `UsageError`."""
        try:
            with self.archive.open(info) as member:
                yield member
        except ARCHIVE_ERRORS as error:
            raise self.fault(info, f"cannot be read: {said(error)}; it is damaged") from None


def _exactly(member: Any, count: int) -> bytes:
    """So many bytes of a member."""
    parts, left = [], count
    while left:
        part = member.read(left)
        if not part:
            raise EOFError(f"ends {counted(left, 'byte')} too early")
        parts.append(part)
        left -= len(part)
    return b"".join(parts) if len(parts) != 1 else parts[0]


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
