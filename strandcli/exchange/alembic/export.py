"""Write strands as curves of Alembic."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...output.files import atomic
from ..objects import SHAPE, Pieces, pieces, renamed
from ..strands import Attribute, Domain, Strands, TimeSample
from ..written import box_of, checked, left_out
from . import layout
from .writer import Kind, Member, Sample, Writer, sampling

EVEN = 1e-6
"""Seconds by which times may be off that are written as even."""
SCOPES: dict[Domain, str] = {"point": "vtx", "strand": "uni", "groom": "con"}
ADDED = {ours: theirs for theirs, ours in layout.NAMES.items() if ours in ("root_uv", "colour")}
"""Names of attributes that are added to curves where they differ from ours."""
OWN = {"width": ("width", 1, ""), "uv": ("uv", 2, "vector"), "normal": ("N", 3, "normal")}
"""Attributes that curves have themselves: name, numbers an element, interpretation."""
TYPES_OF = {one.dtype.replace("?", "|b1"): one.name for one in layout.TYPES if one.dtype}
"""Alembic's names of numpy's types."""
LARGEST_EXTENT = 255
"""Numbers an element."""


def legal(name: str) -> str:
    """A name without what no object of Alembic may have in its own."""
    return "".join(letter if letter.isprintable() and letter != "/" else "_" for letter in name)


def write(path: Path, strands: Strands, samples: Iterable[TimeSample] | None = None) -> list[str]:
    """Write each object of strands as one of linear curves; ``samples``: all points at several times, rising. Returns
    lines for what is left out."""
    there = pieces(strands, legal)
    with atomic(path) as file:
        writer = Writer(file)
        moving = int(samples is not None)
        stored, times = _moments(path, writer, strands, there, samples)
        writer.times = len(times), moving
        holders: list[Member] = []
        lost: set[str] = set()
        for name, piece, (points, boxes) in zip(there.names, there.strands, stored, strict=True):
            geometry, left = _geometry(writer, piece, points, boxes)
            geom = writer.compound(".geom", {"schema": layout.CURVES, "schemaBaseType": layout.BASE}, geometry)
            shape = writer.object(f"{name}{SHAPE}", layout.CURVES, [geom], [], layout.BASE)
            place = writer.compound(".xform", {"schema": layout.XFORM}, [])
            holders.append(writer.object(name, layout.XFORM, [place], [shape]))
            lost |= set(left)
        top = writer.objects([], holders)
        cycle, when = _cycle(times)
        samplings = sampling(0 if moving else 1, 1.0, [0.0])
        if moving:
            samplings += sampling(len(times), cycle, when)
        entries = {"_ai_Application": "strandcli"}
        if moving and len(when) == 1 and cycle != 1.0:
            entries["_ai_DCC_FPS"] = f"{1 / cycle:.6g}"
        writer.close(top, entries, samplings)
    return left_out(strands, ".abc", strands.attributes.keys() - lost) + renamed(strands, legal, ".abc")


def _moments(
    path: Path, writer: Writer, strands: Strands, there: Pieces, samples: Iterable[TimeSample] | None
) -> tuple[list[tuple[list[Sample], list[Sample]]], list[float]]:
    """Write points and their boxes as they come; returns both of each object, and the times."""
    points: list[list[Sample]] = [[] for _ in there.names]
    boxes: list[list[Sample]] = [[] for _ in there.names]
    times: list[float] = []
    for one in checked(path, strands, samples, ".abc"):
        for place, own in enumerate(there.of(one.points)):
            points[place].append(writer.sample(own.astype("<f4", copy=False)))
            boxes[place].append(writer.sample(box_of(own, np.finfo(np.float64).max).reshape(1, 6)))
        times.append(one.seconds)
    return [(_once(own), _once(box)) for own, box in zip(points, boxes, strict=True)], times


def _once(samples: list[Sample]) -> list[Sample]:
    """One sample where all are the same."""
    return samples[:1] if len({one.word for one in samples}) == 1 else samples


def _cycle(times: list[float]) -> tuple[float, Sequence[float]]:
    """Seconds a cycle, and the times in it: one where they are even, else all."""
    if len(times) == 1:
        return 1.0, times
    cycle = (times[-1] - times[0]) / (len(times) - 1)
    even = np.abs(times[0] + cycle * np.arange(len(times)) - times).max() <= min(EVEN, cycle / 100)
    return (cycle, times[:1]) if even else (float(layout.ACYCLIC), times)


def _geometry(
    writer: Writer, strands: Strands, points: list[Sample], boxes: list[Sample]
) -> tuple[list[Member], list[str]]:
    """The properties of the curves, and the names of attributes that are left out."""
    box = Kind("float64_t", 6, {"interpretation": "box"})
    place = Kind("float32_t", 3, {"geoScope": "vtx", "interpretation": "point"})
    basis = np.array([layout.LINEAR, 0, 0, 0], np.uint8)
    found = [
        writer.property(".selfBnds", layout.SCALAR, box, boxes),
        writer.property("P", layout.ARRAY, place, points),
        writer.still("nVertices", Kind("int32_t", 1, {}), strands.counts("<i4")),
        writer.still("curveBasisAndType", Kind("uint8_t", 4, {}), basis, layout.SCALAR),
    ]
    own, added, lost = _attributes(writer, strands)
    found += own
    if added:
        found.append(writer.compound(".arbGeomParams", {}, added))
    return found, lost


def _attributes(writer: Writer, strands: Strands) -> tuple[list[Member], list[Member], list[str]]:
    """Attributes that curves have themselves, those that are added to them, and the names of the rest."""
    own, lost = [], []
    added: dict[str, Member] = {}
    for attribute, one in strands.attributes.items():
        property = _curves_own(attribute, one, strands)
        if property is not None:
            own.append(writer.still(*property))
            continue
        name, numbers = ADDED.get(attribute, attribute), _numbers(one)
        if numbers is None or not name or "/" in name or name in added:
            lost.append(attribute)
        else:
            added[name] = writer.still(name, _kind(one.domain, numbers, attribute == "colour"), numbers)
    return own, list(added.values()), lost


def _curves_own(attribute: str, one: Attribute, strands: Strands) -> tuple[str, Kind, npt.NDArray[Any]] | None:
    """Name, kind and values (rows, numbers) of an attribute that curves have themselves; None of the rest. Widths of
    strands become those of their points: Blender takes no other ones."""
    if attribute not in OWN or one.values.dtype.kind != "f":
        return None
    name, extent, interpretation = OWN[attribute]
    if one.values.size != extent * one.values.shape[0]:
        return None
    values, domain = one.values.astype("<f4", copy=False).reshape(-1, extent), one.domain
    if name == "width" and domain == "strand":
        values, domain = np.repeat(values, strands.counts(), axis=0), "point"
    return name, _kind(domain, values, False, interpretation), values


def _numbers(one: Attribute) -> npt.NDArray[Any] | None:
    """Values as (rows, numbers), None where Alembic has no such."""
    rows = one.values.shape[0]
    values = one.values.reshape(rows, -1) if one.values.size else one.values.reshape(0, 1)
    dtype = values.dtype.newbyteorder("<").str
    return values if dtype in TYPES_OF and 0 < values.shape[1] <= LARGEST_EXTENT else None


def _kind(domain: Domain, values: npt.NDArray[Any], colour: bool, interpretation: str = "") -> Kind:
    """What the values (rows, numbers) of a domain are, as Alembic's parameters of geometry tell it."""
    extent = values.shape[1]
    meaning = interpretation
    if not meaning and values.dtype.kind == "f":
        meaning = {3: "rgb", 4: "rgba"}.get(extent, "") if colour else "vector" if extent in (2, 3) else ""
    name = TYPES_OF[values.dtype.newbyteorder("<").str]
    metadata = {
        "arrayExtent": "1", "geoScope": SCOPES[domain], "interpretation": meaning, "isGeomParam": "true",
        "podExtent": str(extent), "podName": name,
    }  # fmt: skip
    return Kind(name, extent, metadata)
