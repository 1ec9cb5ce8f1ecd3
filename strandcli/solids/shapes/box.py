"""Box: packed row, bounding ball, depth of points."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.motion import Pose

X, Y, Z = range(3)
"""Columns of a packed box: its centre, metres."""
ROW_X, ROW_Y, ROW_Z = 3, 6, 9
"""Where the rows of its rotation begin: world = rotation · own. Column ROW_X + k is x of its own axis k."""
HALF = 12
"""The first of its three half extents, metres."""
LEAST = 15
"""The squared length below which a direction counts as none."""
COLUMNS = 16
TINY = 1e-30


def numbers(solid: Any, pose: Pose) -> list[float]:
    """Return the packed row of a solid with a pose."""
    a, b, c = pose.rotation
    return [*pose.translation, *a, *b, *c, *(side / 2 for side in solid.size), TINY]


def ball(row: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return centre and radius of the bounding ball of a packed solid."""
    return row[:3], float(np.linalg.norm(row[HALF : HALF + 3]))


def depth(row: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (k,) the depth of points (k, 3) below the nearest face, metres; not positive outside."""
    own = np.abs((points - row[:3]) @ row[ROW_X:HALF].reshape(3, 3))
    return np.asarray((row[HALF : HALF + 3] - own).min(1))
