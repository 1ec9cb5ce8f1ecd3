"""The points of a mesh that are nearest to others."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .bvh import Bvh
from .kernels.closest import closest as _closest


class Closest(NamedTuple):
    """Of each point (P of them) the nearest one of a mesh.

    points: (P, 3) float64; triangles: (P,) int32, numbers in the mesh; barycentrics: (P, 3) float64, shares of the
    triangle's three corners; distances: (P,) float64, negative inside.
    """

    points: npt.NDArray[np.float64]
    triangles: npt.NDArray[np.int32]
    barycentrics: npt.NDArray[np.float64]
    distances: npt.NDArray[np.float64]


def closest(bvh: Bvh, points: npt.NDArray[Any]) -> Closest:
    """The nearest points of a mesh; points: (P, 3), units of the mesh, finite."""
    given = np.ascontiguousarray(points, np.float64)
    count = given.shape[0]
    found = Closest(np.empty((count, 3)), np.empty(count, np.int32), np.empty((count, 3)), np.empty(count))
    _closest(bvh, given, *found)
    return found
