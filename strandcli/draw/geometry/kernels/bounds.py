"""Bounding boxes of strands."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange


@parallel
def find(positions, low, high):
    """Write the least and greatest coordinates of each strand of positions (blocks, n + 1, 3 W), from its root on, to
    low and high (blocks, 3 W)."""
    for block in prange(positions.shape[0]):
        b = np.int64(block)
        bound(positions[b], low[b], high[b])


@device
def bound(rows, low, high):
    """`find` of a block (n + 1, 3 W)."""
    for k in range(3 * W):
        low[k] = rows[1, k]
        high[k] = rows[1, k]
    for j in range(2, rows.shape[0]):
        for k in range(3 * W):
            low[k] = min(low[k], rows[j, k])
            high[k] = max(high[k], rows[j, k])
