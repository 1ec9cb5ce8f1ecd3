"""Bounding boxes of strands."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange
from ...common.kernels.numbers import ZERO

FARTHEST = np.float32(1e6)
"""Metres that a box moves where nothing ends its way."""


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


@parallel
def mark_inside(low, high, sides, along, floors, room, marks):
    """Set the marks of strands whose boxes come within ``room`` metres of a convex body as they move along a vector.

    low, high (blocks, 3 W) metres: from `bounds.find`; sides (P, 4): inward unit normal n and offset d of each side,
    n · x + d >= 0 inside; along (3,): unit vector, or 0; floors (F, 4): the same of planes below which a box goes no
    farther; marks (blocks, W) uint8, changed.
    """
    for block in prange(low.shape[0]):
        b = np.int64(block)
        work = np.empty((3, W), np.float32)
        find_ends(low[b], high[b], along, floors, room, work)
        work[1] = ZERO
        for p in range(sides.shape[0]):
            rise = max(sides[p, 0] * along[0] + sides[p, 1] * along[1] + sides[p, 2] * along[2], ZERO)
            reach(low[b], high[b], sides[p], room, work[2])
            for lane in range(W):
                work[1, lane] = min(work[1, lane], work[2, lane] + rise * work[0, lane])
        for lane in range(W):
            marks[b, lane] |= np.uint8(work[1, lane] >= ZERO)


@device
def find_ends(low, high, along, floors, room, work):
    """Store in work[0] how far boxes move until all of them and ``room`` is below one of the floors, metres."""
    work[0] = FARTHEST
    for f in range(floors.shape[0]):
        fall = -(floors[f, 0] * along[0] + floors[f, 1] * along[1] + floors[f, 2] * along[2])
        if fall > ZERO:
            reach(low, high, floors[f], room, work[2])
            for lane in range(W):
                work[0, lane] = min(work[0, lane], max(work[2, lane] / fall, ZERO))


@device
def reach(low, high, side, room, out):
    """Write how far the boxes of a block, and ``room`` about them, reach above a plane, metres, to out (W,)."""
    for lane in range(W):
        x = max(side[0] * low[lane], side[0] * high[lane])
        y = max(side[1] * low[W + lane], side[1] * high[W + lane])
        z = max(side[2] * low[2 * W + lane], side[2] * high[2 * W + lane])
        out[lane] = x + y + z + side[3] + room
