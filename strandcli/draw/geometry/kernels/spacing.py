"""Distances from points to the nearest strands."""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange
from ...common.kernels.numbers import ONE, ZERO
from .boxes import GROUP, GROUPS, PART, square_to_box

TINY = np.float32(1e-30)
X, Y, Z = range(3)
"""Columns of `points`."""


@parallel
def nearest(positions, strands, boxes, points, own, out):
    """Write the distances from each point to its k nearest strands, ascending, metres; inf if there are fewer.

    positions (blocks, n + 1, 3 W): row 1 is the root; the first ``strands`` count; boxes: from `boxes.find`, of these;
    points (P, 3); own (P,) int64: a strand that is left out for each point, −1 for none; out (P, k). All but indices
    float32.
    """
    blocks, whole = np.int64(boxes.shape[0]), boxes.shape[1] - 1
    for point in prange(points.shape[0]):
        p = np.int64(point)
        least = np.empty(W, np.float32)
        for k in range(out.shape[1]):
            out[p, k] = np.inf
        home = max(own[p], 0) // W  # searched first, so that most other blocks are too far away
        for turn in range(blocks):
            block = np.int64(turn if turn > home else turn - 1 if turn > 0 else home)
            if square_to_box(boxes[block, whole], points[p, X], points[p, Y], points[p, Z]) > out[p, -1]:
                continue
            if not squares_to_strands(positions[block], boxes[block], points[p], out[p, -1], least):
                continue
            for k in range(min(W, strands - block * W)):
                if block * W + k != own[p] and least[k] < out[p, -1]:
                    insert_sorted(out, p, least[k])
        for k in range(out.shape[1]):
            out[p, k] = math.sqrt(out[p, k])


@device
def squares_to_strands(rows, boxes, point, most, least):
    """Write the squared distances from a point (3,) to the strands of a block (n + 1, 3 W) to least (W,), as far as
    they are less than `most`: strands of a part whose box is farther away are left out there. Return whether any is
    not. boxes: those of the block."""
    x, y, z = point[X], point[Y], point[Z]
    for k in range(W):
        least[k] = np.inf
    found = False
    for begin in range(2, rows.shape[0], PART):
        for group in range(GROUPS):
            if square_to_box(boxes[(begin - 2) // PART * GROUPS + group], x, y, z) > most:
                continue
            found = True
            for row in range(begin, min(begin + PART, rows.shape[0])):
                for k in range(group * GROUP, (group + 1) * GROUP):
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
    return found


@device
def insert_sorted(out, p, value):
    """Insert a value into the ascending row out[p]; the greatest drops out."""
    k = out.shape[1] - 1
    while k > 0 and out[p, k - 1] > value:
        out[p, k] = out[p, k - 1]
        k -= 1
    out[p, k] = value
