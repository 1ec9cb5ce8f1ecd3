"""Scale and up axis."""

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
    changed = replace(_apply(strands, turning(up, to)), source=replace(strands.source, up=to))
    return changed, Change("up", f"{up} turned to {to}", {"from": up, "to": to})


def scaled(strands: Strands, factor: float) -> tuple[Strands, Change]:
    """Strands times a factor, about the origin."""
    unit = strands.source.unit
    source = replace(strands.source, unit=None if unit is None else unit / factor)
    changed = replace(_apply(strands, np.eye(3), factor), source=source)
    return changed, Change("scale", f"scaled by {factor:g}", {"factor": factor})


def _apply(strands: Strands, turn: Matrix, factor: float = 1.0) -> Strands:
    """Strands under a turn (3, 3) and then a factor."""
    found = {}
    for name, one in strands.attributes.items():
        values: npt.NDArray[Any] = one.values
        if name == "width" and factor != 1:
            values = np.multiply(values, factor, dtype=np.float64).astype(values.dtype)
        elif name.endswith("normal") and values.shape[-1:] == (3,):
            values = (values @ turn.T).astype(values.dtype)
        found[name] = Attribute(one.domain, values)
    points = _mapped(strands.points, factor * turn)
    if not_finite(points)[0]:
        raise UsageError("points are too far out for single precision after --scale")
    return replace(strands, points=points, attributes=found)


def _mapped(points: Points, linear: Matrix) -> Points:
    out = np.empty_like(points)
    with np.errstate(over="ignore"):
        for begin in range(0, points.shape[0], CHUNK):
            part = points[begin : begin + CHUNK].astype(np.float64)
            # numbers that a matrix leaves alone keep their bits
            out[begin : begin + CHUNK] = sum(part[:, j, None] * linear[:, j] for j in range(3))
    return out
