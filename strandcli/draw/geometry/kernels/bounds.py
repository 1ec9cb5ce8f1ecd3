"""Bounding boxes of strands."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, function, parallel, prange

ZERO = np.float32(0.0)
INF = np.float32(np.inf)


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


@function
def hold_whole(low, high, fade, whole, box):
    """Write to box (2, 3 W) the least and greatest coordinates of the strands of each lane whose `fade` is `whole`; inf
    and −inf if there are none.

    low, high (blocks, 3 W): from `find`; fade (blocks, W): −1 for lanes that are no strands.
    """
    box[0] = INF
    box[1] = -INF
    for block in range(fade.shape[0]):
        for axis in range(3):
            for lane in range(W):
                k = axis * W + lane
                there = fade[block, lane] == whole
                box[0, k] = min(box[0, k], low[block, k] if there else INF)
                box[1, k] = max(box[1, k], high[block, k] if there else -INF)


@function
def extend(low, high, fade, whole, inner, beyond):
    """Write to beyond (2, 3 W) by how much strands of each lane that fade extend the box inner (2, 3), at most 0 and at
    least 0; arguments as in `hold_whole`."""
    beyond[:] = 0.0
    for block in range(fade.shape[0]):
        for axis in range(3):
            for lane in range(W):
                k = axis * W + lane
                share = fade[block, lane] if (fade[block, lane] > ZERO) & (fade[block, lane] != whole) else ZERO
                beyond[0, k] = min(beyond[0, k], (low[block, k] - inner[0, axis]) * share)
                beyond[1, k] = max(beyond[1, k], (high[block, k] - inner[1, axis]) * share)
