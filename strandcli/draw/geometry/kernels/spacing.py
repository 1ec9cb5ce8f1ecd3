"""How far strands lie from each other."""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)
SURE = np.float32(0.98)


@parallel
def nearest(positions, strands, points, own, out):
    """Into out (P, k): how far the nearest k strands but its ``own`` (P,) int64 are from each of the points (P, 3),
    ascending, metres; infinite where there are no more.

    positions (blocks, n + 1, 3 W): of the first ``strands``, from row 1 on. All but indices float32.
    """
    blocks = np.int64((strands + W - 1) // W)
    boxes = np.empty((blocks, 6), np.float32)
    for block in prange(blocks):
        enclose(positions, block, min(W, strands - block * W), np.empty(W, np.float32), np.empty(W, np.float32), boxes)
    for p in prange(points.shape[0]):
        least = np.empty(W, np.float32)
        for k in range(out.shape[1]):
            out[p, k] = np.inf
        home = max(own[p], 0) // W  # first, so that few others are near enough
        for turn in range(blocks):
            block = np.int64(turn if turn > home else turn - 1 if turn > 0 else home)
            if beyond(boxes, block, points[p, 0], points[p, 1], points[p, 2]) > out[p, -1]:
                continue
            approach(positions, block, points[p, 0], points[p, 1], points[p, 2], least)
            for k in range(min(W, strands - block * W)):
                if block * W + k != own[p] and least[k] < out[p, -1]:
                    put_in_order(out, p, least[k])
        for k in range(out.shape[1]):
            out[p, k] = math.sqrt(out[p, k])


@device
def enclose(positions, block, lanes, low, high, boxes):
    """Into boxes[block]: the least and the greatest coordinates of the block's strands, of which there are `lanes`;
    low, high (W,): to work with."""
    for c in range(3):
        for k in range(W):
            low[k] = np.inf
            high[k] = -np.inf
        for row in range(1, positions.shape[1]):
            for k in range(W):
                low[k] = min(low[k], positions[block, row, c * W + k])
                high[k] = max(high[k], positions[block, row, c * W + k])
        boxes[block, c] = np.inf
        boxes[block, c + 3] = -np.inf
        for k in range(lanes):
            boxes[block, c] = min(boxes[block, c], low[k])
            boxes[block, c + 3] = max(boxes[block, c + 3], high[k])


@device
def beyond(boxes, block, x, y, z):
    """Square of what a point is off a block at least, whatever the rounding."""
    x = max(max(boxes[block, 0] - x, x - boxes[block, 3]), ZERO)
    y = max(max(boxes[block, 1] - y, y - boxes[block, 4]), ZERO)
    z = max(max(boxes[block, 2] - z, z - boxes[block, 5]), ZERO)
    return SURE * (x * x + y * y + z * z)


@device
def approach(positions, block, x, y, z, least):
    """Into least (W,): squares of the distances from a point to the strands of a block."""
    for k in range(W):
        least[k] = np.inf
    for row in range(2, positions.shape[1]):
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


@device
def put_in_order(out, p, value):
    """Into its place among out[p], whose last drops out."""
    k = out.shape[1] - 1
    while k > 0 and out[p, k - 1] > value:
        out[p, k] = out[p, k - 1]
        k -= 1
    out[p, k] = value
