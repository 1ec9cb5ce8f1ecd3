"""`.npz`, arrays of numpy.

DiffLocks writes ``positions`` (N, P, 3) with ``root_uv`` (N, 2) and ``root_normal`` (N, 3); hairutil calls the points
``point``. Strands that differ in length are ``points`` (P, 3) and ``first`` (N + 1,), of each strand its first point.
Objects are ``object_names`` (K,), text, and where there are several, ``object`` (N,), of each strand the number of its
own.
"""

from __future__ import annotations

import math
import sys
import zipfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...errors import UsageError, said
from ...output.files import ARCHIVE_ERRORS, atomic
from ..bounded import Bounded, amount, opened
from ..files import ReadOptions
from ..objects import renamed, written_names
from ..strands import OBJECT, Attribute, Domain, Source, Strands, TimeSample, even_offsets, without_short
from ..written import left_out, with_width_each

name = ".npz"
suffixes = (".npz",)

USUAL = ("positions", "point", "points", "strands", "vertices", "xyz")
"""Names of the array of points, where several have its shape."""
FIRST, POINTS, POSITIONS, OBJECT_NAMES = "first", "points", "positions", "object_names"


LARGEST_DIRECTORY = 1 << 20
"""Bytes of an archive's list of members: one of a thousand arrays has a twentieth of it."""
SPARE = 1 << 26
"""Bytes that arrays may take beyond three times the file: packed ones may be of any size."""
HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
"""Readers of headers, by their version; later ones are of records."""
DAMAGED = (*ARCHIVE_ERRORS, UserWarning)
"""What a damaged array or archive raises."""


class Member(NamedTuple):
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
        """Read the headers of all arrays; ``members`` are of numbers, ``texts`` of text, the rest are left out."""
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


def sniff(head: bytes, size: int) -> bool:
    """Whether it is an archive."""
    return head.startswith((b"PK\3\4", b"PK\5\6"))


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file, and as attributes the arrays with a row for each strand or point."""
    with opened(path, ".npz file", options.lenient) as file, arrays_of(file) as archive:
        members = archive.members
        ragged = FIRST in members and POINTS in members and options.array is None
        member = members[POINTS] if ragged else _chosen(file, members, options.array)
        points = _read(file, archive, member).reshape(-1, 3)
        if ragged:
            first = archive.read(members[FIRST])
            shape = members[POINTS].shape
            fine = shape[1:] == (3,) and first.ndim == 1 and first.dtype.kind in "iu" and first.size > 0
            first = first.astype(np.int64) if fine else first
            if not fine or first[0] != 0 or first[-1] != shape[0] or (np.diff(first) < 0).any():
                raise archive.fault(members[FIRST].info, f"does not divide points of shape {shape} into strands")
        else:
            first = even_offsets(*member.shape[:2])
        attributes = {}
        for one in members.values():
            domain = _domain(one, first.size - 1, points.shape[0], member.shape)
            if one is not member and domain and not (ragged and one.name == FIRST):
                values = _read(file, archive, one)
                flat = values.reshape(-1, *values.shape[2:]) if domain == "point" and not ragged else values
                attributes[one.name] = Attribute(domain, flat)
        retained = {member.name, FIRST, *attributes}
        objects = _objects(archive, attributes)
    facts: dict[str, Any] = {"array": member.name, "shape": list(member.shape), "type": str(member.kind)}
    unread = [one for one in members if one not in retained]
    if unread:
        facts["arrays_not_read"] = unread
    return without_short(Strands(first, points, attributes, Source(name, facts=facts), objects))


def _objects(archive: Archive, attributes: dict[str, Attribute]) -> tuple[str, ...]:
    """The names of objects, () where there are none. Raises `UsageError` where strands are of unnamed ones."""
    if OBJECT_NAMES not in archive.texts:
        return ()
    member = archive.texts[OBJECT_NAMES]
    found, of = archive.text(member), attributes.get(OBJECT)
    if of is None:
        return found if len(found) == 1 else ()
    numbers = of.values
    if of.domain != "strand" or numbers.ndim != 1 or numbers.dtype.kind not in "iu":
        raise archive.fault(member.info, f"{OBJECT} has no whole number for each strand")
    if numbers.size and not 0 <= int(numbers.min()) <= int(numbers.max()) < len(found):
        raise archive.fault(member.info, f"{len(found):,} names, {OBJECT} has numbers from {int(numbers.min()):,} to "
                            f"{int(numbers.max()):,}")  # fmt: skip
    attributes[OBJECT] = Attribute("strand", numbers.astype(np.int32))
    return found


def _read(file: Bounded, archive: Archive, member: Member) -> Any:
    values = archive.read(member)
    begin = member.info.header_offset
    rows = values.reshape(-1, values.shape[-1]) if values.ndim > 2 else values
    file.finite(member.name, rows, lambda row: begin)
    return values


def _chosen(file: Bounded, members: dict[str, Member], wanted: str | None) -> Member:
    """The array of points. Raises `UsageError` where it is not clear which it is."""
    shaped = {
        one.name: one
        for one in members.values()
        if one.kind.kind == "f" and len(one.shape) == 3 and one.shape[1] > 0 and one.shape[2] == 3
    }
    if wanted is not None:
        if wanted not in shaped:
            raise UsageError(f"{file.path}: --array {wanted}: {_there(members, shaped)}")
        return shaped[wanted]
    if len(shaped) == 1:
        return next(iter(shaped.values()))
    for one in USUAL:
        if one in shaped:
            return shaped[one]
    which = "; choose one with --array NAME, or to draw it with --set emitter.groom.array=NAME" if shaped else ""
    raise UsageError(f"{file.path}: {_there(members, shaped)}{which}")


def _there(members: dict[str, Member], shaped: dict[str, Member]) -> str:
    if shaped:
        return f"arrays of strands are {', '.join(f'{one.name} {one.shape}' for one in shaped.values())}"
    listed = ", ".join(f"{one.name} {one.shape} of {one.kind}" for one in members.values())
    return f"has no array of floating-point numbers of shape (strands, points, 3); there are {listed or 'none'}"


def _domain(one: Member, strands: int, points: int, shape: tuple[int, ...]) -> Domain | None:
    """What an array has a row for; None where it belongs to no strands."""
    if len(shape) == 3 and len(one.shape) >= 2 and one.shape[:2] == shape[:2]:
        return "point"
    if one.shape[:1] == (strands,):
        return "strand"
    if len(shape) == 2 and one.shape[:1] == (points,):
        return "point"
    return None


def write(path: Path, strands: Strands, samples: Iterable[TimeSample] | None = None) -> list[str]:
    """Write ``positions`` where all strands have as many points, else ``points`` and ``first``; attributes beside."""
    strands = with_width_each(strands)
    equal = strands.equal()
    each = (strands.count, equal) if equal else (strands.points.shape[0],)
    arrays: dict[str, Any] = {POSITIONS if equal else POINTS: strands.points.reshape(*each, 3)}
    if not equal:
        arrays[FIRST] = strands.first
    if strands.objects:
        arrays[OBJECT_NAMES] = np.array(written_names(strands.objects, str))
    lost = set()
    for attribute, one in strands.attributes.items():
        if one.domain == "groom" or attribute in (POSITIONS, POINTS, FIRST, OBJECT_NAMES):
            lost.add(attribute)
        else:
            shape = each if one.domain == "point" else (strands.count,)
            arrays[attribute] = one.values.reshape(*shape, *one.values.shape[1:])
    with atomic(path) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        for array, values in arrays.items():
            entry = zipfile.ZipInfo(f"{array}.npy")  # of no date: the same strands make the same bytes
            with archive.open(entry, "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.ascontiguousarray(values), allow_pickle=False)
    return left_out(strands, name, strands.attributes.keys() - lost) + renamed(strands, str, name)
