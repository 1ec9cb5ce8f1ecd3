"""`.npz`, arrays of numpy.

DiffLocks writes ``positions`` (N, P, 3) with ``root_uv`` (N, 2) and ``root_normal`` (N, 3); hairutil calls the points
``point``. Strands that differ in length are ``points`` (P, 3) and ``first`` (N + 1,), of each strand its first point.
Objects are ``object_names`` (K,), text, and where there are several, ``object`` (N,), of each strand the number of its
own.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import UsageError
from ...output.files import atomic
from ..archive import Archive, Member, arrays_of
from ..bounded import Bounded, opened
from ..files import ReadOptions
from ..objects import renamed, written_names
from ..strands import OBJECT, Attribute, Domain, Source, Strands, TimeSample, even_offsets, without_short
from ..written import left_out, with_width_each

name = ".npz"
suffixes = (".npz",)

USUAL = ("positions", "point", "points", "strands", "vertices", "xyz")
"""Names of the array of points, where several have its shape."""
FIRST, POINTS, POSITIONS, OBJECT_NAMES = "first", "points", "positions", "object_names"


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
        kept = {member.name, FIRST, *attributes}
        objects = _objects(archive, attributes)
    facts: dict[str, Any] = {"array": member.name, "shape": list(member.shape), "type": str(member.kind)}
    unread = [one for one in members if one not in kept]
    if unread:
        facts["arrays_not_read"] = unread
    return without_short(Strands(first, points, attributes, Source(name, facts=facts), objects))


def _objects(archive: Archive, attributes: dict[str, Attribute]) -> tuple[str, ...]:
    """The names of objects, () where there are none. Raises `UsageError` where strands are of others."""
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
