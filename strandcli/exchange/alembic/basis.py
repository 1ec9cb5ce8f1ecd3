"""What the control points of curves of Alembic mean."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..control import Knots
from ..splines import BEZIER, BSPLINE, CATMULL_ROM, CUBIC, LINEAR, MATRICES, Basis
from . import layout
from .archive import Archive, Property

Geometry = dict[str, Property]
STRAIGHT = "joined straight"


def basis_of(archive: Archive, path: str, geometry: Geometry, curves: int) -> tuple[Basis, Knots | None]:
    """What the control points of so many curves mean, and the knots of NURBS. Raises `UsageError` for curves that are
    not read. Cubic ones without a basis are joined straight, as Blender and Houdini do."""
    told = geometry.get("curveBasisAndType")
    if told is None or told.kind == layout.COMPOUND or told.extent < 3 or not told.samples or not told.dtype:
        return Basis(LINEAR), None
    curve, periodic, number = (int(one) for one in archive.values(told).reshape(-1)[:3])
    wrap = "periodic" if periodic else "nonperiodic"
    name = layout.BASES[number] if 0 <= number < len(layout.BASES) else f"of number {number}"
    if curve == layout.LINEAR:
        return Basis(LINEAR, wrap=wrap), None
    at = geometry["P"].child.at
    orders, knots, weights = (_numbers(archive, geometry.get(name)) for name in (".orders", ".knots", "w"))
    if weights.size and (weights != weights[0]).any():
        raise archive.file.fault(f"{path}: NURBS with weights that differ are not read", at)
    if knots.size:
        return Basis(CUBIC, BEZIER, label="NURBS"), Knots(
            np.full(curves, 4) if curve == layout.CUBIC else orders, knots
        )
    if curve != layout.CUBIC:
        found, uniform = _variable(name, wrap, orders)
        if found is None:
            raise archive.file.fault(f"{path}: periodic NURBS without knots are read of orders 2 and 4 alone", at)
        return found, uniform
    if not name:
        return Basis(LINEAR, wrap=wrap, label=f"cubic without a basis, {STRAIGHT}"), None
    if name not in MATRICES:
        raise archive.file.fault(f"{path}: cubic curves of the basis {name} are not read", at)
    return Basis(CUBIC, name, wrap), None


def _variable(name: str, wrap: str, orders: npt.NDArray[Any]) -> tuple[Basis | None, Knots | None]:
    """What control points of curves of any order without knots mean; None of what is not read.

    Blender writes such: polygons of no basis; Catmull-Rom splines, which it has go through all points; and NURBS with
    their orders, whose knots are uniform.
    """
    if name == CATMULL_ROM and wrap != "periodic":
        return Basis(CUBIC, name, "pinned"), None
    if name != BSPLINE or not orders.size:
        return Basis(LINEAR, wrap=wrap, label=f"{name} of no orders, {STRAIGHT}" if name else ""), None
    if (orders == 2).all():
        return Basis(LINEAR, wrap=wrap), None
    if (orders == 4).all():
        return Basis(CUBIC, BSPLINE, wrap), None
    return (None, None) if wrap == "periodic" else (Basis(CUBIC, BEZIER, label="NURBS"), Knots(orders, np.zeros(0)))


def _numbers(archive: Archive, found: Property | None) -> npt.NDArray[Any]:
    """The first sample of a property (n,), none where it is not there."""
    if found is None or found.kind == layout.COMPOUND or not found.dtype or not found.samples:
        return np.zeros(0)
    return archive.values(found).reshape(-1)
