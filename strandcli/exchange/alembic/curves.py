"""Curves of an Alembic archive, each object as it is stored, where transforms put it; `strandcli.exchange.parts` makes
strands of all of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.rotations import of_quaternion
from ..parts import Matrix, Part, part_of
from ..splines import BSPLINE, CATMULL_ROM, CUBIC, LINEAR, MATRICES, STRAIGHT, Basis, Fitter, of_nurbs
from . import layout
from .archive import Archive, Object, Property

Geometry = dict[str, Property]


def basis_of(archive: Archive, path: str, geometry: Geometry) -> Basis:
    """What control points mean. Raises `UsageError` for curves that are not read. Cubic ones without a basis are joined
    straight, as Blender and Houdini do."""
    entry = geometry.get("curveBasisAndType")
    if entry is None or entry.kind == layout.COMPOUND or entry.extent < 3 or not entry.samples or not entry.dtype:
        return Basis(LINEAR)
    curve, periodic, number = (int(one) for one in archive.values(entry).reshape(-1)[:3])
    wrap = "periodic" if periodic else "nonperiodic"
    name = layout.BASES[number] if 0 <= number < len(layout.BASES) else f"of number {number}"
    if curve == layout.LINEAR:
        return Basis(LINEAR, wrap=wrap)
    at = geometry["P"].child.at
    orders, knots, weights = (_numbers(archive, geometry.get(name)) for name in (".orders", ".knots", "w"))
    if weights.size and (weights != weights[0]).any():
        raise archive.file.fault(f"{path}: NURBS with weights that differ are not read", at)
    if knots.size or (curve != layout.CUBIC and name == BSPLINE):
        return of_nurbs(np.array([4]) if curve == layout.CUBIC else orders, knots, wrap)
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


def chain(archive: Archive, one: Object) -> list[Geometry]:
    """The properties of transforms that hold an object, inner ones first."""
    found = []
    holder = one.parent
    while holder is not None:
        if holder.metadata.get("schema", "").startswith("AbcGeom_Xform"):
            xform = archive.properties(holder).get(".xform")
            if xform is not None and xform.kind == layout.COMPOUND:
                found.append(archive.compound(xform))
        holder = holder.parent
    return found


def world(archive: Archive, transforms: list[Geometry], seconds: float | None) -> Matrix | None:
    """Where transforms, inner ones first, put what they hold: at a time, or in their first samples. None where it is
    there already, so that points keep their bits."""
    found = np.eye(4)
    for one in transforms:
        found = found @ _matrix(archive, one, seconds)
        inherits = one.get(".inherits")
        if inherits is not None and inherits.samples and not archive.at(inherits, seconds).any():
            break
    return None if np.array_equal(found, np.eye(4)) else found


def _matrix(archive: Archive, one: Geometry, seconds: float | None) -> Matrix:
    """The operations of a transform, of which the last is the first to be done."""
    found = np.eye(4)
    operations, entry = one.get(".ops"), one.get(".vals")
    if operations is None or entry is None or not operations.samples:
        return found
    codes = [int(code) >> 4 for code in archive.values(operations).reshape(-1)]
    values = archive.at(entry, seconds).reshape(-1).astype(np.float64)
    if set(codes) - set(layout.CHANNELS) or sum(layout.CHANNELS[code] for code in codes) != values.size:
        raise archive.file.damaged(f"{entry.path}: {values.size:,} numbers of operations {codes}", entry.child.at)
    for code in codes:
        count = layout.CHANNELS[code]
        found = _operation(code, values[:count]) @ found
        values = values[count:]
    return found


def _operation(code: int, values: npt.NDArray[np.float64]) -> Matrix:
    found = np.eye(4)
    if code == layout.MATRIX:
        return values.reshape(4, 4)
    if code == layout.TRANSLATE:
        found[3, :3] = values
    elif code == layout.SCALE:
        found[:3, :3] = np.diag(values)
    elif code == layout.ROTATE:
        found[:3, :3] = _turn(values[:3], float(values[3]))
    else:
        found[:3, :3] = _turn(np.eye(3)[code - layout.ROTATE_X], float(values[0]))
    return found


def _turn(axis: npt.NDArray[np.float64], degrees: float) -> Matrix:
    """A turn (3, 3) about an axis, for rows."""
    length = float(np.linalg.norm(axis))
    if not length > 0:
        return np.eye(3)
    half = math.radians(degrees) / 2
    return of_quaternion(np.array([math.cos(half), *(math.sin(half) / length * axis)])).T


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """An object of curves: its path, properties of its geometry by name, those that may be attributes by our names,
    and properties of the transforms that hold it."""

    path: str
    geometry: Geometry
    attributes: Geometry
    transforms: list[Geometry]

    def moving(self) -> list[Property]:
        """What says where points are: positions, and numbers of transforms that change."""
        values = [one[".vals"] for one in self.transforms if ".vals" in one]
        return [self.geometry["P"], *(one for one in values if one.last)]


def curves_of(archive: Archive, one: Object) -> Curves:
    """An object of curves. Raises `UsageError` where it has no points."""
    geometry = archive.properties(one).get(".geom")
    if geometry is None or geometry.kind != layout.COMPOUND:
        raise archive.file.damaged(f"{one.path}: has no .geom", one.group.begin)
    entry = archive.compound(geometry)
    for name, extent, kinds in (("P", 3, "f"), ("nVertices", 1, "iu")):
        found = entry.get(name)
        if found is None or found.kind == layout.COMPOUND:
            raise archive.file.damaged(f"{geometry.path}: has no {name}", geometry.child.at)
        if found.extent != extent or np.dtype(found.dtype or "S").kind not in kinds:
            kind = layout.TYPES[found.type].name
            raise archive.file.damaged(f"{found.path}: {found.extent} {kind} an element", found.child.at)
    return Curves(one.path, entry, _attributes(archive, entry), chain(archive, one))


def read_part(archive: Archive, one: Curves, fitter: Fitter, seconds: float | None = None) -> Part:
    """The points on curves at a time or in the first sample, and their attributes. Raises `UsageError` where control
    points make no curves."""
    entry, place = one.geometry["nVertices"], one.geometry["P"]
    counts = archive.at(entry, seconds).reshape(-1)
    if counts.size and (int(counts.min()) < 0 or int(counts.max()) > np.iinfo(np.int32).max):
        worst = int(np.argmin(counts) if int(counts.min()) < 0 else np.argmax(counts))
        raise archive.file.damaged(f"{entry.path}: curve {worst:,} has {counts[worst]:,} points", entry.child.at)
    control = archive.at(place, seconds).astype(np.float32, copy=False)
    basis, at = basis_of(archive, one.path, one.geometry), place.child.at
    curves = fitter.fitted(
        one.path, counts.astype(np.int64), control, basis, lambda words: archive.file.fault(words, at)
    )
    values = ((name, *_values(archive, entry, seconds)) for name, entry in one.attributes.items())
    return part_of(one.path, curves, control, fitter, world(archive, one.transforms, seconds), values)


def _attributes(archive: Archive, geometry: Geometry) -> Geometry:
    """Properties that may be attributes, by our names: curves' own go before those that are added to them."""
    found = {layout.NAMES.get(name, name): geometry[name] for name in ("width", "uv", "N") if name in geometry}
    added = geometry.get(".arbGeomParams")
    if added is not None and added.kind == layout.COMPOUND:
        for name, entry in archive.compound(added).items():
            found.setdefault(layout.NAMES.get(name, name), entry)
    return found


def _values(archive: Archive, entry: Property, seconds: float | None) -> tuple[str, npt.NDArray[Any] | None]:
    """What a property's sample at a time, or its first, belongs to, and its rows of numbers; None of other things."""
    values_of, indices = entry, None
    if entry.kind == layout.COMPOUND:
        both = archive.compound(entry)
        if ".vals" not in both or ".indices" not in both:
            return "", None
        indices, values_of = both[".indices"], both[".vals"]
    if not values_of.dtype or not values_of.samples or values_of.kind == layout.COMPOUND:
        return "", None
    values: Any = archive.at(values_of, seconds)
    if indices is not None:
        values = _expanded(archive, indices, values, seconds)
    scope = entry.metadata.get("geoScope", values_of.metadata.get("geoScope", ""))
    if values_of.dtype == "?":
        values = (values != 0).astype(np.int8)
    return layout.SCOPES.get(scope, ""), values


def _expanded(archive: Archive, indices: Property, values: Any, seconds: float | None) -> Any:
    """Values by index: a row for each."""
    if not indices.dtype or indices.extent != 1 or np.dtype(indices.dtype).kind not in "iu":
        raise archive.file.damaged(f"{indices.path}: are no indices", indices.child.at)
    rows = archive.at(indices, seconds).reshape(-1)
    if rows.size and not 0 <= int(rows.min()) <= int(rows.max()) < values.shape[0]:
        raise archive.file.damaged(f"{indices.path}: not all are below {values.shape[0]:,}", indices.child.at)
    archive.container.spend(indices.path, rows.size * values.itemsize * values.shape[1], indices.child.at)
    return values[rows]
