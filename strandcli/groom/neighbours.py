"""Nearest neighbours among roots: of strands their guides, of strands the middles of their locks."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .kernels.nearest import Cells

A_CELL = 2.0
"""Points a cell of the grid in which they are looked for, on average over its area."""
CODE = (__name__, f"{__package__}.kernels.nearest", f"{__package__}.kernels.alike")
"""Modules that neighbours follow from."""
ROUNDING = 1e-6
"""Of the grid's extent and distance from the origin; positions have single precision."""


def nearest_of(
    points: NDArray[np.float32], others: NDArray[np.float32], many: int
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Return the numbers (N, many) int32 of the nearest of others (G, D) to each of points (N, D), nearest first, and
    their squared distances, float32; many <= G, D >= 3. The first three coordinates are of a place; all count."""
    from .kernels.nearest import nearest

    found = np.empty((len(points), many), np.int32)
    squares = np.empty((len(points), many), np.float32)
    nearest(points, cells_of(others), found, squares)
    return found, squares


def cells_of(points: NDArray[np.float32]) -> Cells:
    """Return points (G, D) by the cells of a grid over those two of their first three coordinates that vary most."""
    from .kernels.nearest import Cells

    places = points[:, :3].astype(np.float64)
    low, extent = places.min(0), np.ptp(places, axis=0)
    b, a = (int(axis) for axis in np.argsort(extent, kind="stable")[1:])
    most = max(float(extent[a]), 1e-30)
    # as many cells as points have use for, and of a line no rows of them
    size = max(math.sqrt(most * float(extent[b]) * A_CELL / len(points)), most * A_CELL / len(points))
    columns, rows = (max(math.ceil(float(extent[axis]) / size), 1) for axis in (a, b))
    x, y = (
        np.clip((places[:, axis] - low[axis]) / size, 0, count - 1).astype(np.int64)
        for axis, count in ((a, columns), (b, rows))
    )
    cell = y * columns + x
    order = np.argsort(cell, kind="stable").astype(np.int32)
    begins = np.zeros(rows * columns + 1, np.int32)
    begins[1:] = np.cumsum(np.bincount(cell, minlength=rows * columns))
    slack = ROUNDING * (most + float(np.abs(places).max()))
    return Cells(
        np.ascontiguousarray(points[order]), order, begins, a, b, float(low[a]), float(low[b]), size, columns, rows,
        slack,
    )  # fmt: skip
