"""Scale, up axis, and any affine matrix."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import UsageError
from ..bounded import not_finite
from ..strands import CHUNK, Attribute, Points, Strands
from .moving import Change

Matrix = npt.NDArray[np.float64]
AXES = ("x", "y", "z", "-x", "-y", "-z")
SINGULAR = 1e-12
"""A determinant, over the cube of the largest entry, under which a matrix is flat."""


def axis(name: str) -> Matrix:
    """The unit vector of one of `AXES`."""
    vector = np.zeros(3)
    vector["xyz".index(name[-1])] = -1.0 if name.startswith("-") else 1.0
    return vector


def turning(up: str, to: str) -> Matrix:
    """The turn (3, 3) that takes one axis to another, by the shorter way; its entries are whole."""
    a, b = axis(up), axis(to)
    if up == to:
        return np.eye(3)
    if (a == -b).all():  # half a turn about another axis
        other = np.roll(np.abs(a), 1)
        return 2 * np.outer(other, other) - np.eye(3)
    across = np.cross(a, b)
    return np.outer(b, a) - np.outer(a, b) + np.outer(across, across)


def turned(strands: Strands, up: str, to: str) -> tuple[Strands, Change]:
    """Strands whose up axis ``up`` becomes ``to``."""
    changed = replace(_apply(strands, turning(up, to), np.zeros(3)), source=replace(strands.source, up=to))
    return changed, Change("up", f"{up} turned to {to}", {"from": up, "to": to})


def scaled(strands: Strands, factor: float) -> tuple[Strands, Change]:
    """Strands times a factor, about the origin."""
    unit = strands.source.unit
    source = replace(strands.source, unit=None if unit is None else unit / factor)
    changed = replace(_apply(strands, factor * np.eye(3), np.zeros(3)), source=source)
    return changed, Change("scale", f"scaled by {factor:g}", {"factor": factor})


def moved(strands: Strands, matrix: Matrix) -> tuple[Strands, Change]:
    """Strands under a matrix (3, 4): p ↦ A p + b. Raises `UsageError` where A is flat."""
    linear = matrix[:, :3]
    if not abs(np.linalg.det(linear)) > SINGULAR * np.abs(linear).max() ** 3:
        raise UsageError("--matrix: makes all points lie in one plane")
    mirrored = bool(np.linalg.det(linear) < 0)
    changed = _apply(strands, linear, matrix[:, 3])
    changed = replace(changed, source=replace(strands.source, unit=None, up=None))
    text = "transformed by a matrix" + (" that mirrors" if mirrored else "")
    return changed, Change("matrix", text, {"matrix": matrix.tolist(), "mirrors": mirrored})


def _apply(strands: Strands, linear: Matrix, shift: Matrix) -> Strands:
    size = float(np.cbrt(abs(np.linalg.det(linear))))
    found = {}
    for name, one in strands.attributes.items():
        values: npt.NDArray[Any] = one.values
        if name == "width":
            values = np.multiply(values, size, out=strands.room(values), dtype=np.float64, casting="unsafe")
        elif name.endswith("normal") and values.shape[-1:] == (3,):
            values = _directions(values, np.linalg.inv(linear).T)
        found[name] = Attribute(one.domain, values)
    points = _mapped(strands.points, linear, shift, strands.room(strands.points))
    if not_finite(points)[0]:
        raise UsageError("points are too far out for single precision after --scale or --matrix")
    return replace(strands, points=points, attributes=found)


def _mapped(points: Points, linear: Matrix, shift: Matrix, out: Points) -> Points:
    with np.errstate(over="ignore"):
        for begin in range(0, points.shape[0], CHUNK):
            part = points[begin : begin + CHUNK].astype(np.float64)
            # numbers that a matrix leaves alone keep their bits
            out[begin : begin + CHUNK] = sum(part[:, j, None] * linear[:, j] for j in range(3)) + shift
    return out


def _directions(values: npt.NDArray[Any], linear: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Vectors of the same lengths in the directions that a matrix gives them."""
    found = np.empty_like(values)
    for begin in range(0, values.shape[0], CHUNK):
        part = values[begin : begin + CHUNK].astype(np.float64)
        turned = part @ linear.T
        before, after = (np.linalg.norm(one, axis=-1, keepdims=True) for one in (part, turned))
        found[begin : begin + CHUNK] = turned * (before / np.where(after > 0, after, 1.0))
    return found
