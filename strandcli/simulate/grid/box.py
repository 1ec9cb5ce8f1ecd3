"""Boxes of cells about strands that interact, of each part of them and of all; and cells of another box."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from .kernels.records import FIRST, LANES, LOW, OFFSET, SIZE

MOST_CELLS = 4_000_000
"""Of the box about the strands: some 120 bytes each, 470 MB."""


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


def lay_boxes(
    ends: NDArray[Any], parts: NDArray[np.int64], cell: float, margin: int, where: str, boxes: NDArray[np.int64]
) -> bool:
    """Set the ``boxes`` (parts + 1, `BOX`) about the strands of each part, and ``margin`` cells wider about all. Return
    False where a coordinate is not finite. Raises `UsageError` where they take too many cells.

    ends: as `Moving.ends`; cell: side of a cell, metres; where: the rule, for the message."""
    greatest = np.maximum.reduceat(ends, parts[:, FIRST]).astype(np.float64)
    low, high = np.floor(-greatest[:, :3] / cell - 0.5), np.floor(greatest[:, 3:] / cell - 0.5) + 1
    along = high.max(0) - low.min(0) + 1
    if not np.isfinite(along).all():
        return False
    if (cells := (along + 2 * margin).prod()) > MOST_CELLS:
        factor = 1.0
        while np.prod(np.ceil(along / factor) + 1 + 2 * margin) > MOST_CELLS:  # a flat groom has few across
            factor *= 1.05
        raise UsageError(
            f"{where}.cell: cells of {cell:.3g} m would be {cells:.3g} in the box about the strands, more than "
            f"{MOST_CELLS:,}; make them at least {1.05 * factor * cell:.2g}"
        )
    boxes[:-1, LOW : LOW + 3], boxes[-1, LOW : LOW + 3] = low, low.min(0) - margin
    boxes[:-1, SIZE : SIZE + 3], boxes[-1, SIZE : SIZE + 3] = high - low + 1, along + 2 * margin
    boxes[-1, SIZE] = -(-boxes[-1, SIZE] // LANES) * LANES
    counts = boxes[:-1, SIZE : SIZE + 3].prod(1)
    boxes[:-1, OFFSET] = np.cumsum(counts) - counts
    return True
