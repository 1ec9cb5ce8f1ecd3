"""Capsule: packed row, bounding ball, depth of points."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.motion import Pose, rotate

X, Y, Z, AXIS_X, AXIS_Y, AXIS_Z, RADIUS, PER_SQUARE, LEAST = range(9)
"""Columns of a packed capsule: first end of its axis, the vector to the other end, radius, metres; 1 / the vector's
squared length; the squared length below which a direction counts as none."""
COLUMNS = 9
TINY = 1e-30


def numbers(solid: Any, pose: Pose) -> list[float]:
    """Return the packed row of a solid with a pose."""
    x, y, z = rotate(pose.rotation, (0.0, 1.0, 0.0))
    u, v, w = pose.translation
    size = solid.length
    axis = x * size, y * size, z * size
    first = u - axis[0] / 2, v - axis[1] / 2, w - axis[2] / 2
    return [*first, *axis, solid.radius, 1 / max(size**2, TINY), TINY]


def ball(row: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return centre and radius of the bounding ball of a packed solid."""
    axis = row[AXIS_X : AXIS_Z + 1]
    return row[:3] + axis / 2, float(np.linalg.norm(axis) / 2 + row[RADIUS])


def depth(row: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (k,) the depth of points (k, 3) below the surface, metres; not positive outside."""
    axis = row[AXIS_X : AXIS_Z + 1]
    along = np.clip((points - row[:3]) @ axis * row[PER_SQUARE], 0, 1)
    return np.asarray(row[RADIUS] - np.linalg.norm(points - row[:3] - along[:, None] * axis, axis=1))
