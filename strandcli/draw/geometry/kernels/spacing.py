"""Distances from points to the nearest strands."""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)
SAFE = np.float32(0.98)
"""Factor of the distance to a bounding box, so that rounding never makes it too great."""
X, Y, Z = range(3)
"""Columns of `points`."""
LOW_X, LOW_Y, LOW_Z, HIGH_X, HIGH_Y, HIGH_Z = range(6)
"""Columns of `boxes`: least and greatest coordinates."""
PART = 8
"""Segments of a part of a block that has a box of its own."""


@parallel
def nearest(positions, strands, points, own, out):
    """Write the distances from each point to its k nearest strands, ascending, metres; inf if there are fewer.

    positions (blocks, n + 1, 3 W): row 1 is the root; the first ``strands`` count; points (P, 3); own (P,) int64: a
    strand that is left out for each point, −1 for none; out (P, k). All but indices float32.
    """
    blocks = np.int64((strands + W - 1) // W)
    parts = np.int64(max((positions.shape[1] - 2 + PART - 1) // PART, 1))
    boxes = np.empty((blocks * (parts + 1), 6), np.float32)  # of the parts of a block, and then of the whole of it
    for one in prange(blocks):
        block = np.int64(one)
        lanes, first = min(W, strands - block * W), block * (parts + 1)
        bound(positions, block, lanes, first, np.empty(W, np.float32), np.empty(W, np.float32), boxes)
    for point in prange(points.shape[0]):
        p = np.int64(point)
        least = np.empty(W, np.float32)
        for k in range(out.shape[1]):
            out[p, k] = np.inf
        home = max(own[p], 0) // W  # searched first, so that most other blocks are too far away
        for turn in range(blocks):
            block = np.int64(turn if turn > home else turn - 1 if turn > 0 else home)
            first = block * (parts + 1)
            if square_to_box(boxes, first + parts, points[p, X], points[p, Y], points[p, Z]) > out[p, -1]:
                continue
            if not squares_to_strands(
                positions, block, points[p, X], points[p, Y], points[p, Z], boxes, first, out[p, -1], least
            ):
                continue
            for k in range(min(W, strands - block * W)):
                if block * W + k != own[p] and least[k] < out[p, -1]:
                    insert_sorted(out, p, least[k])
        for k in range(out.shape[1]):
            out[p, k] = math.sqrt(out[p, k])


@device
def bound(positions, block, lanes, first, low, high, boxes):
    """Write the bounding boxes of the parts of a block's first `lanes` strands to boxes[first] and behind, and that of
    the whole of them behind these; low, high (W,): scratch."""
    last = positions.shape[1] - 1
    parts = max((last - 1 + PART - 1) // PART, 1)
    whole = first + parts
    for c in range(3):
        boxes[whole, LOW_X + c] = np.inf
        boxes[whole, HIGH_X + c] = -np.inf
        for part in range(parts):
            at = first + part
            for k in range(W):
                low[k] = np.inf
                high[k] = -np.inf
            for row in range(1 + part * PART, min(1 + (part + 1) * PART, last) + 1):
                for k in range(W):
                    low[k] = min(low[k], positions[block, row, c * W + k])
                    high[k] = max(high[k], positions[block, row, c * W + k])
            boxes[at, LOW_X + c] = np.inf
            boxes[at, HIGH_X + c] = -np.inf
            for k in range(lanes):
                boxes[at, LOW_X + c] = min(boxes[at, LOW_X + c], low[k])
                boxes[at, HIGH_X + c] = max(boxes[at, HIGH_X + c], high[k])
            boxes[whole, LOW_X + c] = min(boxes[whole, LOW_X + c], boxes[at, LOW_X + c])
            boxes[whole, HIGH_X + c] = max(boxes[whole, HIGH_X + c], boxes[at, HIGH_X + c])


@device
def square_to_box(boxes, block, x, y, z):
    """Return a lower bound of the squared distance from a point to the strands in box number `block`."""
    x = max(max(boxes[block, LOW_X] - x, x - boxes[block, HIGH_X]), ZERO)
    y = max(max(boxes[block, LOW_Y] - y, y - boxes[block, HIGH_Y]), ZERO)
    z = max(max(boxes[block, LOW_Z] - z, z - boxes[block, HIGH_Z]), ZERO)
    return SAFE * (x * x + y * y + z * z)


@device
def squares_to_strands(positions, block, x, y, z, boxes, first, most, least):
    """Write the squared distances from a point to the strands of a block to least (W,), as far as they are less than
    `most`: parts that are farther away are left out. Return whether any is not. boxes, first: as in `bound`."""
    for k in range(W):
        least[k] = np.inf
    found = False
    for begin in range(2, positions.shape[1], PART):
        if square_to_box(boxes, first + (begin - 2) // PART, x, y, z) > most:
            continue
        found = True
        for row in range(begin, min(begin + PART, positions.shape[1])):
            for k in range(W):
                ax = positions[block, row - 1, k] - x
                ay = positions[block, row - 1, W + k] - y
                az = positions[block, row - 1, 2 * W + k] - z
                ex = positions[block, row, k] - x - ax
                ey = positions[block, row, W + k] - y - ay
                ez = positions[block, row, 2 * W + k] - z - az
                t = min(max(-(ax * ex + ay * ey + az * ez) / max(ex * ex + ey * ey + ez * ez, TINY), ZERO), ONE)
                ax += t * ex
                ay += t * ey
                az += t * ez
                least[k] = min(least[k], ax * ax + ay * ay + az * az)
    return found


@device
def insert_sorted(out, p, value):
    """Insert a value into the ascending row out[p]; the greatest drops out."""
    k = out.shape[1] - 1
    while k > 0 and out[p, k - 1] > value:
        out[p, k] = out[p, k - 1]
        k -= 1
    out[p, k] = value
