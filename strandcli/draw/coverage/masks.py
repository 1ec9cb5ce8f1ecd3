"""Table of `kernels.masks`: bit masks of the points of a sample on one side of a line."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from .kernels.masks import DIRECTIONS, DISTANCES, POINTS, REACH


def points() -> NDArray[np.float64]:
    """Return the points of a sample, (64, 2) in [−½, ½): the Hammersley set, with one point in each of 64 equal strips
    along either axis."""
    i = np.arange(POINTS)
    reverse = sum(((i >> bit) & 1) << (5 - bit) for bit in range(6))
    return np.asarray((np.column_stack([i, reverse]) + 0.5) / POINTS - 0.5)


@functools.cache
def half_planes() -> NDArray[np.uint64]:
    """Return masks ((DIRECTIONS + 1) * (DISTANCES + 1),) for each normal n, in the order of `kernels.masks.table_row`,
    and distance d from the sample's centre: a bit for each point p with p · n < d."""
    turn = np.arange(DIRECTIONS + 1) * (2.0 / DIRECTIONS)
    x, y = 1 - turn, np.minimum(turn, 2 - turn)
    normal = np.column_stack([x, y]) / np.hypot(x, y)[:, None]
    distance = np.linspace(-float(REACH), float(REACH), DISTANCES + 1)
    behind = (normal @ points().T)[:, None] < distance[:, None]
    bits = behind.astype(np.uint64) << np.arange(POINTS, dtype=np.uint64)
    return np.asarray(np.bitwise_or.reduce(bits, -1).ravel())
