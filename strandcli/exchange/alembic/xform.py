"""Transforms of Alembic: the objects that hold curves, and where they put them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...common.rotations import of_quaternion
from ..parts import Matrix
from . import layout
from .archive import Archive, Object, Property


@dataclass(frozen=True, slots=True, eq=False)
class Transform:
    """What an object that is a transform tells: operations, their numbers, and whether it follows what holds it; None
    where it does not tell."""

    operations: Property | None
    values: Property | None
    inherits: Property | None


def chain(archive: Archive, one: Object) -> list[Transform]:
    """The transforms that hold an object, inner ones first."""
    found = []
    holder = one.parent
    while holder is not None:
        if holder.metadata.get("schema", "").startswith("AbcGeom_Xform"):
            xform = archive.properties(holder).get(".xform")
            if xform is not None and xform.kind == layout.COMPOUND:
                stated = archive.compound(xform)
                found.append(Transform(stated.get(".ops"), stated.get(".vals"), stated.get(".inherits")))
        holder = holder.parent
    return found


def world(archive: Archive, transforms: list[Transform], seconds: float | None) -> Matrix | None:
    """Where transforms, inner ones first, put what they hold: at a time, or in their first samples. None where it is
    there already, so that points keep their bits."""
    found = np.eye(4)
    for one in transforms:
        found = found @ _matrix(archive, one, seconds)
        if one.inherits is not None and one.inherits.samples:
            inherits = archive.at(one.inherits, seconds)
            if not inherits.any():
                break
    return None if np.array_equal(found, np.eye(4)) else found


def _matrix(archive: Archive, one: Transform, seconds: float | None) -> Matrix:
    """The operations of a transform, of which the last is the first to be done."""
    found = np.eye(4)
    if one.operations is None or one.values is None or not one.operations.samples:
        return found
    codes = [int(code) >> 4 for code in archive.values(one.operations).reshape(-1)]
    values = archive.at(one.values, seconds).reshape(-1).astype(np.float64)
    if set(codes) - set(layout.CHANNELS) or sum(layout.CHANNELS[code] for code in codes) != values.size:
        raise archive.file.damaged(
            f"{one.values.path}: {values.size:,} numbers of operations {codes}", one.values.child.at
        )
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
