"""The grid that contact looks for neighbours in, without the kernels that do: `plan` counts with it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

MOST_ENTRIES = 16
"""Cells a box lies in at the most, as a mean: larger cells are taken otherwise."""

Floats = NDArray[np.float64]


def cell_side(low: Floats, high: Floats) -> float:
    """Return the side of cells for boxes with such corners (m, 3), metres."""
    side = float((high - low).mean() * 1.5)
    while (np.floor(high / side) - np.floor(low / side) + 1).prod(1).mean() > MOST_ENTRIES:
        side *= 1.5
    return side
