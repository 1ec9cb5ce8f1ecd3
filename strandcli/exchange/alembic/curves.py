"""Curves of an Alembic archive, each object as it is told; `strandcli.exchange.parts` makes strands of all of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..parts import Part, moved, moved_attribute
from ..splines import (
    BSPLINE,
    CATMULL_ROM,
    CUBIC,
    LINEAR,
    MATRICES,
    NURBS,
    STRAIGHT,
    Basis,
    ControlCurves,
    Fitter,
    is_clamped,
)
from ..strands import Attribute
from . import layout
from .archive import CLOSE, Archive, Object, Property
from .xform import Transform, chain, world

Geometry = dict[str, Property]


def basis_of(archive: Archive, path: str, geometry: Geometry) -> Basis:
    """What control points mean. Raises `UsageError` for curves that are not read. Cubic ones without a basis are joined
    straight, as Blender and Houdini do; NURBS of order 4 are taken as uniform B-splines, which reach their ends where
    knots clamp them, and others joined straight."""
    told = geometry.get("curveBasisAndType")
    if told is None or told.kind == layout.COMPOUND or told.extent < 3 or not told.samples or not told.dtype:
        return Basis(LINEAR)
    curve, periodic, number = (int(one) for one in archive.values(told).reshape(-1)[:3])
    wrap = "periodic" if periodic else "nonperiodic"
    name = layout.BASES[number] if 0 <= number < len(layout.BASES) else f"of number {number}"
    if curve == layout.LINEAR:
        return Basis(LINEAR, wrap=wrap)
    at = geometry["P"].child.at
    orders, knots, weights = (_numbers(archive, geometry.get(name)) for name in (".orders", ".knots", "w"))
    if weights.size and (weights != weights[0]).any():
        raise archive.file.fault(f"{path}: NURBS with weights that differ are not read", at)
    if knots.size or (curve != layout.CUBIC and name == BSPLINE):
        if curve == layout.CUBIC or (orders.size and (orders == 4).all()):
            return Basis(CUBIC, BSPLINE, "pinned" if is_clamped(knots) else wrap, NURBS)
        return Basis(LINEAR, wrap=wrap, label=f"{NURBS} of other orders than 4, {STRAIGHT}")
    if curve != layout.CUBIC and name == CATMULL_ROM:  # Blender's, which go through all points
        return Basis(CUBIC, name, wrap if periodic else "pinned")
    if not name or curve != layout.CUBIC:
        return Basis(LINEAR, wrap=wrap, label=f"cubic without a basis, {STRAIGHT}" if curve == layout.CUBIC else "")
    if name not in MATRICES:
        raise archive.file.fault(f"{path}: cubic curves of the basis {name} are not read", at)
    return Basis(CUBIC, name, wrap)


def _numbers(archive: Archive, found: Property | None) -> npt.NDArray[Any]:
    """The first sample of a property (n,), none where it is not there."""
    if found is None or found.kind == layout.COMPOUND or not found.dtype or not found.samples:
        return np.zeros(0)
    return archive.values(found).reshape(-1)


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """An object of curves: its path, properties of its geometry by name, and the transforms that hold it."""

    path: str
    geometry: dict[str, Property]
    transforms: list[Transform]

    @property
    def points(self) -> Property:
        """The positions."""
        return self.geometry["P"]

    @property
    def counts(self) -> Property:
        """Points of each curve."""
        return self.geometry["nVertices"]


class Clock:
    """When objects of curves change, gathered from each of them as it is read."""

    def __init__(self) -> None:
        self._times: set[float] = set()
        self._cycles: set[float] = set()
        self.changing: set[str] = set()
        """Attributes, by our names, that change with time."""

    def add(self, archive: Archive, one: Curves, attributes: Mapping[str, Property]) -> None:
        """Take in an object with attributes."""
        moving = [move.values for move in one.transforms if move.values and move.values.last]
        for told in (one.points, *moving):
            self._times.update(archive.times(told))
            if told.last and 0 < told.sampling.cycle < layout.ACYCLIC:
                self._cycles.add(told.sampling.cycle)
        for name, told in attributes.items():
            parts = archive.compound(told).values() if told.kind == layout.COMPOUND else (told,)
            self.changing.update([name] if any(part.last for part in parts) else [])

    @property
    def times(self) -> list[float]:
        """Seconds at which points change, rising."""
        found = sorted(self._times)
        return [time for place, time in enumerate(found) if not place or time - found[place - 1] > CLOSE]

    @property
    def rate(self) -> float | None:
        """Frames a second of samples that are taken at equal distances or in cycles; None where none are."""
        return 1 / min(self._cycles) if self._cycles else None


def all_curves(archive: Archive) -> Iterator[Curves]:
    """The objects of curves of an archive, one after the other. Raises `UsageError` where there are none."""
    found, others = False, set()
    for one in archive.objects():
        schema = one.metadata.get("schema", "")
        if schema.startswith("AbcGeom_Curve_"):
            found = True
            yield _curves(archive, one)
        else:
            others.add(schema or "no schema")
    if not found:
        there = f"; there are objects of {', '.join(sorted(others)[:5])}" if others else ""
        raise archive.file.fault(f"has no curves{there}", archive.container.root.at)


def _curves(archive: Archive, one: Object) -> Curves:
    geometry = archive.properties(one).get(".geom")
    if geometry is None or geometry.kind != layout.COMPOUND:
        raise archive.file.damaged(f"{one.path}: has no .geom", one.group.begin)
    told = archive.compound(geometry)
    for name, extent, kinds in (("P", 3, "f"), ("nVertices", 1, "iu")):
        found = told.get(name)
        if found is None or found.kind == layout.COMPOUND:
            raise archive.file.damaged(f"{geometry.path}: has no {name}", geometry.child.at)
        if found.extent != extent or np.dtype(found.dtype or "S").kind not in kinds:
            kind = layout.TYPES[found.type].name
            raise archive.file.damaged(f"{found.path}: {found.extent} {kind} an element", found.child.at)
    return Curves(one.path, told, chain(archive, one))


def part_of(
    archive: Archive, one: Curves, told_of: Mapping[str, Property], fitter: Fitter, seconds: float | None = None
) -> Part:
    """The points on curves at a time or in the first sample, and their attributes. Raises `UsageError` where control
    points make no curves."""
    told = one.counts
    counts = archive.at(told, seconds).reshape(-1)
    if counts.size and (int(counts.min()) < 0 or int(counts.max()) > np.iinfo(np.int32).max):
        worst = int(np.argmin(counts) if int(counts.min()) < 0 else np.argmax(counts))
        raise archive.file.damaged(f"{told.path}: curve {worst:,} has {counts[worst]:,} points", told.child.at)
    control = archive.at(one.points, seconds).astype(np.float32, copy=False)
    basis, at = basis_of(archive, one.path, one.geometry), one.points.child.at
    curves = fitter.fitted(
        one.path, counts.astype(np.int64), control, basis, lambda words: archive.file.fault(words, at)
    )
    matrix = world(archive, one.transforms, seconds)
    attributes: dict[str, Attribute] = {}
    unread = []
    for name, told in told_of.items():
        found = None if name in attributes else _attribute(archive, told, name, curves, seconds)
        if found is None:
            unread.append(name)
        else:
            attributes[name] = found if matrix is None else moved_attribute(name, found, matrix)
    points, departure = curves.points(control)
    fitter.departure = max(fitter.departure, departure)
    return Part(one.path, curves.point_counts(), moved(points, matrix), attributes, unread)


def attributes_of(archive: Archive, one: Curves) -> dict[str, Property]:
    """Properties that may be attributes, by our names: curves' own go before those that are added to them."""
    found = {layout.NAMES.get(name, name): one.geometry[name] for name in ("width", "uv", "N") if name in one.geometry}
    added = one.geometry.get(".arbGeomParams")
    if added is not None and added.kind == layout.COMPOUND:
        for name, told in archive.compound(added).items():
            found.setdefault(layout.NAMES.get(name, name), told)
    return found


def _attribute(
    archive: Archive, told: Property, name: str, curves: ControlCurves, seconds: float | None
) -> Attribute | None:  # fmt: skip
    """A property's sample at a time, or its first; None where it has no row for each point or strand or for all."""
    indices = None
    if told.kind == layout.COMPOUND:
        both = archive.compound(told)
        if ".vals" not in both or ".indices" not in both:
            return None
        indices, values_of = both[".indices"], both[".vals"]
    else:
        values_of = told
    if not values_of.dtype or not values_of.samples or values_of.kind == layout.COMPOUND:
        return None
    values: Any = archive.at(values_of, seconds)
    if indices is not None:
        values = _expanded(archive, indices, values, seconds)
    scope = told.metadata.get("geoScope", values_of.metadata.get("geoScope", ""))
    if values_of.dtype == "?":
        values = (values != 0).astype(np.int8)
    return curves.attribute(name, layout.SCOPES.get(scope, ""), values)


def _expanded(archive: Archive, indices: Property, values: Any, seconds: float | None) -> Any:
    """Values by index: a row for each."""
    if not indices.dtype or indices.extent != 1 or np.dtype(indices.dtype).kind not in "iu":
        raise archive.file.damaged(f"{indices.path}: are no indices", indices.child.at)
    rows = archive.at(indices, seconds).reshape(-1)
    if rows.size and not 0 <= int(rows.min()) <= int(rows.max()) < values.shape[0]:
        raise archive.file.damaged(f"{indices.path}: not all are below {values.shape[0]:,}", indices.child.at)
    archive.container.spend(indices.path, rows.size * values.itemsize * values.shape[1], indices.child.at)
    return values[rows]
