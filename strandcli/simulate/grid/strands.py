"""What the grid of strands that interact knows of them: the points at which they are sampled, the boxes of cells about
them, and the step that it is laid for."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...errors import UsageError
from ...solids import Solids
from ..rod.kernels.arrays import PACK
from .kernels.records import FIRST, LANES, LOW, OFFSET, SIZE

MOST_CELLS = 4_000_000
"""Of the box about the strands: some 120 bytes each, 470 MB."""


class Points(NamedTuple):
    """Points at which every strand is sampled, as `records.Samples` has them."""

    first: NDArray[np.int64]
    counts: NDArray[np.int64]
    weights: NDArray[np.float64]
    mass: NDArray[np.float64]


def samples_of(segments: NDArray[np.float64], length: float) -> Points:
    """Return the samples of strands whose segments have the relative masses ``segments`` (N,) and the length
    ``length``, in cells, of the longest. A sample of several segments is a mean by masses."""
    n = len(segments)
    several = max(1, math.ceil(length * (1 - 1e-6)))
    if several > 1:
        t = np.tile((np.arange(several) + 0.5) / several, n)
        first = np.repeat(np.arange(n), several)
        weights, mass = np.stack([1 - t, t], 1), np.repeat(segments / several, several)
        return Points(first, np.full(len(first), 2), weights, mass)
    group = min(max(1, int(1 / length * (1 + 1e-6))), n)
    first = np.arange(0, n, group)
    count = np.minimum(first + group, n) - first + 1
    weights, mass = np.zeros((len(first), group + 1)), np.zeros(len(first))
    for row, begin, end in zip(range(len(first)), first, first + count - 1, strict=True):
        mass[row] = segments[begin:end].sum()
        weights[row, : end - begin] += segments[begin:end] / 2 / mass[row]
        weights[row, 1 : end - begin + 1] += segments[begin:end] / 2 / mass[row]
    return Points(first, count, weights, mass)


class Moment(NamedTuple):
    """The step that strands are prepared for."""

    step: float
    """Its length, seconds."""
    wind: tuple[float, float, float]
    """Acceleration of strands at rest by the open wind, m/s²."""
    gravity: tuple[float, float, float]
    """m/s²."""
    solids: Solids | None
    """Those that strands collide with, at its end."""


def ends_of(positions: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return (blocks, 3) the least and the greatest coordinates of strands in blocks; NaN where one is."""
    rows = positions[:, 1:].reshape(len(positions), -1, 3, W)
    return rows.min((1, 3)), rows.max((1, 3))


def extent_of(positions: NDArray[Any]) -> float:
    """Return the greatest extent along an axis of strands in blocks."""
    low, high = ends_of(positions)
    return float((high.max(0) - low.min(0)).max())


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
    positions: NDArray[Any], parts: NDArray[np.int64], cell: float, margin: int, where: str, boxes: NDArray[np.int64]
) -> bool:
    """Set the ``boxes`` (parts + 1, `BOX`) about the strands of each part, of whole blocks, and ``margin`` cells wider
    about all. Return False where a coordinate is not finite. Raises `UsageError` where they take too many cells.

    cell: side of a cell, metres; where: the rule, for the message."""
    least, greatest = ends_of(positions)
    first = parts[:, FIRST] * PACK // W
    low = np.floor(np.minimum.reduceat(least, first).astype(np.float64) / cell - 0.5)
    high = np.floor(np.maximum.reduceat(greatest, first).astype(np.float64) / cell - 0.5) + 1
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
