"""The points of a sample that lie on one side of a line, as masks of bits: the table of `kernels.masks`."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from .kernels.masks import DISTANCES, POINTS, REACH, WAYS


def points() -> NDArray[np.float64]:
    """(64, 2) in [−½, ½): the Hammersley set, of which each of 64 equal strips along either axis has one point."""
    i = np.arange(POINTS)
    reverse = sum(((i >> bit) & 1) << (5 - bit) for bit in range(6))
    return np.asarray((np.column_stack([i, reverse]) + 0.5) / POINTS - 0.5)


@functools.cache
def sides() -> NDArray[np.uint64]:
    """((WAYS + 1) * (DISTANCES + 1),): of lines with the normal n, in the order of `kernels.masks.table_row`, at
    so many distances d from the middle, a bit for each point p with p · n < d."""
    way = np.arange(WAYS + 1) * (2.0 / WAYS)
    x, y = 1 - way, np.minimum(way, 2 - way)
    normal = np.column_stack([x, y]) / np.hypot(x, y)[:, None]
    distance = np.linspace(-float(REACH), float(REACH), DISTANCES + 1)
    behind = (normal @ points().T)[:, None] < distance[:, None]
    bits = behind.astype(np.uint64) << np.arange(POINTS, dtype=np.uint64)
    return np.asarray(np.bitwise_or.reduce(bits, -1).ravel())
