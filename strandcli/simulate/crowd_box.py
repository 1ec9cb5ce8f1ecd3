"""The box of cells about strands that interact: how large it is, and cells of another one."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .kernels.crowd_records import LOW, SIZE


def extent_of(positions: NDArray[Any]) -> float:
    """Return the greatest extent along an axis of strands in blocks."""
    rows = positions[:, 1:].reshape(len(positions), -1, 3, positions.shape[2] // 3)
    return float((rows.max((0, 1, 3)) - rows.min((0, 1, 3))).max())


def moved(values: NDArray[Any], before: NDArray[np.int64], box: NDArray[np.int64]) -> NDArray[Any]:
    """Return the values of cells in another box, 0 where they had none: (z, y, x)."""
    found = np.zeros(box[SIZE : SIZE + 3][::-1], values.dtype)
    if values.size:
        shift = (box[LOW : LOW + 3] - before[LOW : LOW + 3])[::-1]
        ends = list(zip(shift.tolist(), found.shape, values.shape, strict=True))
        here = tuple(slice(max(-d, 0), max(min(a, b - d), 0)) for d, a, b in ends)
        there = tuple(slice(max(d, 0), max(min(b, a + d), 0)) for d, a, b in ends)
        found[here] = values[there]
    return found
