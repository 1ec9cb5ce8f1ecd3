"""Distances from points to the nearest strands."""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange
from ...common.kernels.numbers import INF, ONE, ZERO

TINY = np.float32(1e-30)
SAFE = np.float32(0.98)
"""Factor of the squared distance to a box, so that rounding never makes it too great."""
GROUP = 16
"""Strands, neighbours in a block, that are looked at together."""


@parallel
def nearest(positions, strands, low, high, points, own, out):
    """Write the distances from each point to its k nearest strands, ascending, metres; inf if there are fewer.

    positions (blocks, n + 1, 3 W): row 1 is the root; the first ``strands`` count; low, high: `extent.Extents`;
    points (P, 3); own (P,) int64: a strand that is left out for each point, −1 for none; out (P, k). All but indices
    float32.
    """
    blocks = np.int64((strands + W - 1) // W)
    for point in prange(points.shape[0]):
        p = np.int64(point)
        squares, least = np.empty(W, np.float32), np.empty(W, np.float32)
        for k in range(out.shape[1]):
            out[p, k] = np.inf
        home = max(own[p], 0) // W  # searched first, so that most other blocks are too far away
        for turn in range(blocks):
            block = np.int64(turn if turn > home else turn - 1 if turn > 0 else home)
            squares_to_boxes(low[block], high[block], points[p], squares)
            for begin in range(0, min(W, strands - block * W), GROUP):
                if not squares_to_strands(positions[block], points[p], begin, squares, out[p, -1], least):
                    continue
                for k in range(begin, min(begin + GROUP, strands - block * W)):
                    if block * W + k != own[p] and least[k] < out[p, -1]:
                        at = out.shape[1] - 1
                        while at > 0 and out[p, at - 1] > least[k]:
                            out[p, at] = out[p, at - 1]
                            at -= 1
                        out[p, at] = least[k]
        for k in range(out.shape[1]):
            out[p, k] = math.sqrt(out[p, k])


@device
def squares_to_boxes(low, high, point, squares):
    """Write a lower bound of the squared distance from a point (3,) to each strand of a block, whose boxes are low and
    high (3 W,), to squares (W,)."""
    for k in range(W):
        x = max(max(low[k] - point[0], point[0] - high[k]), ZERO)
        y = max(max(low[W + k] - point[1], point[1] - high[W + k]), ZERO)
        z = max(max(low[2 * W + k] - point[2], point[2] - high[2 * W + k]), ZERO)
        squares[k] = SAFE * (x * x + y * y + z * z)


@device
def squares_to_strands(rows, point, begin, squares, most, least):
    """Write the squared distances from a point (3,) to `GROUP` strands, from number `begin` on, of a block
    (n + 1, 3 W) to least (W,), and return True; or False where all their `squares` are greater than ``most``."""
    near = INF
    for k in range(begin, begin + GROUP):
        near = min(near, squares[k])
        least[k] = INF
    if near > most:
        return False
    x, y, z = point[0], point[1], point[2]
    for row in range(2, rows.shape[0]):
        for k in range(begin, begin + GROUP):
            ax = rows[row - 1, k] - x
            ay = rows[row - 1, W + k] - y
            az = rows[row - 1, 2 * W + k] - z
            ex = rows[row, k] - x - ax
            ey = rows[row, W + k] - y - ay
            ez = rows[row, 2 * W + k] - z - az
            t = min(max(-(ax * ex + ay * ey + az * ez) / max(ex * ex + ey * ey + ez * ez, TINY), ZERO), ONE)
            ax += t * ex
            ay += t * ey
            az += t * ez
            least[k] = min(least[k], ax * ax + ay * ay + az * az)
    return True
