"""How far strands lie from each other."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import inner, parallel, prange

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)


@parallel
def nearest(positions, strands, points, own, out):
    """Into out (P, k): how far the nearest k strands but its ``own`` (P,) int64 are from each of the points (P, 3),
    ascending, metres; infinite where there are no more.

    positions (blocks, n + 1, 3 W): of the first ``strands``, from row 1 on. All but indices float32.
    """
    for p in prange(points.shape[0]):
        least = np.empty(W, np.float32)
        for k in range(out.shape[1]):
            out[p, k] = np.inf
        for block in range((strands + W - 1) // W):
            approach(positions, block, points[p, 0], points[p, 1], points[p, 2], least)
            for k in range(min(W, strands - block * W)):
                if block * W + k != own[p] and least[k] < out[p, -1]:
                    put_in_order(out, p, least[k])
        for k in range(out.shape[1]):
            out[p, k] = math.sqrt(out[p, k])


@inner
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


@inner
def put_in_order(out, p, value):
    """Into its place among out[p], whose last drops out."""
    k = out.shape[1] - 1
    while k > 0 and out[p, k - 1] > value:
        out[p, k] = out[p, k - 1]
        k -= 1
    out[p, k] = value
