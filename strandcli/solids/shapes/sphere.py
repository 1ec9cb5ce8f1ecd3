"""Sphere: packed row, bounding ball, depth of points."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.motion import Pose

X, Y, Z, RADIUS, LEAST = range(5)
"""Columns of a packed sphere: centre and radius, metres; the squared length below which a direction counts as none."""
COLUMNS = 5
TINY = 1e-30


def numbers(solid: Any, pose: Pose) -> list[float]:
    """Return the packed row of a solid with a pose."""
    return [*pose.translation, solid.radius, TINY]


def ball(row: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return centre and radius of the bounding ball of a packed solid."""
    return row[:3], float(row[RADIUS])


def depth(row: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (k,) the depth of points (k, 3) below the surface, metres; not positive outside."""
    return np.asarray(row[RADIUS] - np.linalg.norm(points - row[:3], axis=1))
