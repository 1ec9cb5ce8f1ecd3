"""Bounding boxes of strands that stand beside each other, part by part along them."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange
from ...common.kernels.numbers import INF, ZERO

SAFE = np.float32(0.98)
"""Factor of the distance to a box, so that rounding never makes it too great."""
LOW_X, LOW_Y, LOW_Z, HIGH_X, HIGH_Y, HIGH_Z = range(6)
"""Columns: least and greatest coordinates."""
COLUMNS = 6
PART = 8
"""Segments of a part of a block."""
GROUP = 16
"""Strands, neighbours in a block, that share a box in each part."""
GROUPS = W // GROUP


def boxes_in(rows: int) -> int:
    """Return the number of boxes of a block of so many rows: those of all groups of the first part, of the second and
    so on, and then that of the whole block."""
    return max(-(-(rows - 2) // PART), 1) * GROUPS + 1


@parallel
def find(positions, strands, boxes):
    """Write the boxes of the first ``strands`` of positions (blocks, n + 1, 3 W), from the root on, to boxes (blocks,
    `boxes_in`, COLUMNS); (inf, −inf) where there are none."""
    for one in prange(boxes.shape[0]):
        block = np.int64(one)
        bound(positions[block], min(W, strands - block * W), np.empty((2, W), np.float32), boxes[block])


@device
def bound(rows, lanes, work, boxes):
    """`find` of a block (n + 1, 3 W) with so many strands; work (2, W): scratch."""
    last = rows.shape[0] - 1
    whole = boxes.shape[0] - 1
    for c in range(3):
        boxes[whole, LOW_X + c], boxes[whole, HIGH_X + c] = INF, -INF
        for part in range(whole // GROUPS):
            for k in range(W):
                work[0, k], work[1, k] = INF, -INF
            for row in range(1 + part * PART, min(1 + (part + 1) * PART, last) + 1):
                for k in range(W):
                    work[0, k] = min(work[0, k], rows[row, c * W + k])
                    work[1, k] = max(work[1, k], rows[row, c * W + k])
            for group in range(GROUPS):
                low, high = INF, -INF
                for k in range(group * GROUP, min((group + 1) * GROUP, lanes)):
                    low, high = min(low, work[0, k]), max(high, work[1, k])
                boxes[part * GROUPS + group, LOW_X + c], boxes[part * GROUPS + group, HIGH_X + c] = low, high
                boxes[whole, LOW_X + c] = min(boxes[whole, LOW_X + c], low)
                boxes[whole, HIGH_X + c] = max(boxes[whole, HIGH_X + c], high)


@device
def square_to_box(box, x, y, z):
    """Return a lower bound of the squared distance from a point to the strands in a box."""
    x = max(max(box[LOW_X] - x, x - box[HIGH_X]), ZERO)
    y = max(max(box[LOW_Y] - y, y - box[HIGH_Y]), ZERO)
    z = max(max(box[LOW_Z] - z, z - box[HIGH_Z]), ZERO)
    return SAFE * (x * x + y * y + z * z)
