"""Arrays that the loops of bounds work on, made up and the same each time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

MOST = 2**22
"""Elements of a loop: more take seconds and tell the same."""
COHERENT = 64
"""Vertices that follow each other on a strand."""


def whole(part: float, low: int = 1, high: int = MOST) -> int:
    """Return a number rounded, within bounds."""
    return int(min(max(round(part), low), high))


def uniform(*shape: int, low: float = 0.0, high: float = 1.0) -> Floats:
    """Return random numbers, the same each time."""
    return np.random.default_rng(len(shape)).uniform(low, high, shape).astype(np.float32)


def indices(high: int, *shape: int) -> NDArray[np.int32]:
    """Return random whole numbers from 0 to high − 1, the same each time."""
    return np.random.default_rng(high).integers(0, high, shape, np.int32)


def coherent(count: int) -> Floats:
    """Return (count, 3) places from 0 to 1, runs of `COHERENT` on lines from roots that are near the one before."""
    roots = uniform(-(-count // COHERENT), 3, high=0.9)
    roots = roots[np.lexsort((roots[:, 0], np.floor(16 * roots[:, 1])))]
    way = np.linspace(0, 0.1, COHERENT, dtype=np.float32)[:, None]
    return np.ascontiguousarray((roots[:, None] + way * uniform(len(roots), 1, 3)).reshape(-1, 3)[:count])
