"""Plane, whose solid is all below it: packed row, depth of points."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.motion import Pose, rotate

X, Y, Z, HEIGHT = range(4)
"""Columns of a packed plane: unit normal; the plane's distance from the origin along it, metres."""
COLUMNS = 4


def numbers(solid: Any, pose: Pose) -> list[float]:
    """Return the packed row of a solid with a pose."""
    x, y, z = rotate(pose.rotation, (0.0, 1.0, 0.0))
    u, v, w = pose.translation
    return [x, y, z, x * u + y * v + z * w]


def ball(row: NDArray[np.float64]) -> None:
    """Return None: a plane has no bounding ball."""


def depth(row: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (k,) the depth of points (k, 3) below the surface, metres; not positive outside."""
    return np.asarray(row[HEIGHT] - points @ row[:3])
