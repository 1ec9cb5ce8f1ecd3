"""Points of strands in rows, packed in blocks; and strands whose points move, while segments keep their lengths.

Strands s have the points first[s] to first[s + 1] of flat arrays (P, 3), root first.
"""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...exchange.kernels.along import distance, length
from ...jit import device, parallel, prange
from ...meshes.kernels.distance import distance_and_gradient


@parallel
def place(first, points, most, out):
    """Write to out (P,) the rows that points of strands get where all have ``most``. First (S + 1,) int64 of points
    (P, 3)."""
    for s in prange(first.shape[0] - 1):
        place_strand(points, first[s], first[s + 1], most, out)


@device
def place_strand(points, begin, end, most, out):
    """`place` of the strand of the points from ``begin`` to ``end``; one without length has its points by number."""
    last = end - begin - 1
    whole = length(points, begin, end - 1)
    along = 0.0
    for i in range(last + 1):
        if i > 0:
            along += distance(points, begin + i - 1, begin + i)
        share = along / whole if 0.0 < whole < np.inf else i / last
        out[begin + i] = i + np.rint(share * (most - last - 1))


@parallel
def pack(first, points, rows, order, out):
    """Write strands in an ``order`` (S,) to blocks out (blocks, n + 1, 3 W), as `groom.blocks` has them; first
    (S + 1,) of points (P, 3), of which each strand has n, or which get the rows (P,)."""
    for block in prange(out.shape[0]):
        b = np.int64(block)
        for lane in range(W):
            s = order[min(b * W + lane, order.shape[0] - 1)]
            for c in range(3):
                write_row(points, rows, first[s], first[s + 1], c, out[b, 1:, c * W + lane])
        for k in range(3 * W):
            out[b, 0, k] = np.float32(2.0) * out[b, 1, k] - out[b, 2, k]


@parallel
def spread(first, values, rows, order, out):
    """Write values (P, 1) of the points of strands in an ``order`` (S,), which get the rows (P,), to out (S, n)."""
    for s in prange(out.shape[0]):
        write_row(values, rows, first[order[s]], first[order[s] + 1], 0, out[s])


@device
def write_row(values, rows, begin, end, c, out):
    """Write column c of the values from ``begin`` to ``end`` to out (n,): in their rows, and linear ones between."""
    if rows is None:
        for i in range(begin, end):
            out[i - begin] = values[i, c]
        return
    for i in range(begin, end - 1):
        low, high = np.int64(rows[i]), np.int64(rows[i + 1])
        a, b = np.float64(values[i, c]), np.float64(values[i + 1, c])
        out[low] = values[i, c]
        for k in range(low + 1, high):
            out[k] = a + (k - low) / (high - low) * (b - a)
    out[np.int64(rows[end - 1])] = values[end - 1, c]


TINY = 1e-300
TOWARD = 0.3
"""Share of its lateral distance from where it belongs that a strand makes good for on a segment."""
STEEP = 0.5
"""Tangent of the angle by which a segment is turned for that, at most."""


@parallel
def follow(first, points, targets, lengths):
    """Move the points of strands toward targets (P, 3), roots to theirs; segments keep their lengths (P,), of which
    that of a point is the one before it."""
    for s in prange(first.shape[0] - 1):
        for c in range(3):
            points[first[s], c] = targets[first[s], c]
        for i in range(first[s] + 1, first[s + 1]):
            follow_point(points, targets, i, lengths[i])


@device
def follow_point(points, targets, i, length):
    """Put point i at a length from the one before it, in the direction between the targets of both, turned toward that
    line as far as the point before is off it."""
    px, py, pz = targets[i - 1, 0], targets[i - 1, 1], targets[i - 1, 2]
    bx, by, bz = points[i - 1, 0], points[i - 1, 1], points[i - 1, 2]
    tx, ty, tz = targets[i, 0] - px, targets[i, 1] - py, targets[i, 2] - pz
    size = math.sqrt(tx * tx + ty * ty + tz * tz)
    if length <= 0.0 or size <= 0.0:
        points[i, 0], points[i, 1], points[i, 2] = bx, by, bz
        return
    tx, ty, tz = tx / size, ty / size, tz / size
    ex, ey, ez = px - bx, py - by, pz - bz
    lengthwise = ex * tx + ey * ty + ez * tz
    ex, ey, ez = ex - lengthwise * tx, ey - lengthwise * ty, ez - lengthwise * tz
    off = math.sqrt(ex * ex + ey * ey + ez * ez)
    turn = min(TOWARD, STEEP * length / max(off, TINY)) / length
    tx, ty, tz = tx + turn * ex, ty + turn * ey, tz + turn * ez
    size = length / math.sqrt(tx * tx + ty * ty + tz * tz)
    points[i, 0] = bx + size * tx
    points[i, 1] = by + size * ty
    points[i, 2] = bz + size * tz


@parallel
def grid_distances(grid, points, out):
    """Write the signed distances of points (n, 3) to out (n,); outside of the grid a lower bound."""
    for i in prange(points.shape[0]):
        out[i] = distance_and_gradient(grid, points[i, 0], points[i, 1], points[i, 2])[0]
