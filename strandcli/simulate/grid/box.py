"""The box of cells about strands that interact: how large it is, and cells of another one."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from .kernels.records import LOW, SIZE

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


def require_few(where: str, cells: float, cell: float, ends: NDArray[np.float64], margin: int) -> None:
    """Raise `UsageError` where so many ``cells`` of a side of ``cell`` metres are too many. ``ends``, ``margin``: as
    `coarser` takes them."""
    if cells > MOST_CELLS:
        raise UsageError(
            f"{where}.cell: cells of {cell:.3g} m would be {cells:.3g} in the box about the strands, more than "
            f"{MOST_CELLS:,}; make them at least {coarser(cell, ends, margin):.2g}"
        )


def coarser(cell: float, ends: NDArray[np.float64], margin: int) -> float:
    """Return how large cells can be so that they are few enough, those of a flat groom too. ``ends``, lowest and
    highest cells of strands, part by part, and ``margin``: as `boxes.find_boxes` has them."""
    along = ends[:, 3:].max(0) - ends[:, :3].min(0) + 1
    factor = 1.0
    while np.prod(np.ceil(along / factor) + 1 + 2 * margin) > MOST_CELLS:
        factor *= 1.05
    return 1.05 * factor * cell  # it is told with two digits
