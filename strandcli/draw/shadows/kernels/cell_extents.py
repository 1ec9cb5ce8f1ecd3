"""Nearest and farthest depths of strands in the cells of an opacity map, a batch at a time.

A segment is cut at the borders of rows of cells where it is steep, else of columns. Vectors find which cells each piece
adds to, and a last loop widens their extents, which would wait for the length of each segment otherwise.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, function
from ....simd import floor, half_width_pointer, lane_count, load, store, where
from .minmax import FARTHEST, NEAREST
from .splats import BATCH, COUNT, TINY

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
INF = np.float32(np.inf)
# Rows of a batch: numbers of the first and the last cell of a piece, nearest and farthest depth, metres; distance of
# numbers of cells beside each other.
FIRST, LAST, NEAR, FAR, JUMP = (row * BATCH for row in range(5))


@device
def collect_cells(work, n, begin, end, window, extents):
    """Add the pieces of a segment to a batch of n; return how many it holds then. A full batch widens the extents.

    work (splats.ROWS * BATCH,); begin, end: x and y, texels, and depth, metres; extents: of `OpacityMap`.
    """
    dx, dy, rise = end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]
    steep = abs(dy) >= abs(dx)
    near, far = (begin[1], end[1]) if steep else (begin[0], end[0])
    length = abs(far - near)
    if not (length >= TINY and length <= np.float32(4 * window.width)):
        return n
    low, high = min(near, far), max(near, far)
    slope = ONE / (far - near)
    across, step = (begin[0], dx * slope) if steep else (begin[1], dy * slope)
    top, bottom, left, right = window.top, window.bottom, 0, window.width
    if not steep:
        top, bottom, left, right = left, right, top, bottom
    half = np.float32(window.width >> 1)
    jump, beside = (half, ONE) if steep else (ONE, half)
    rows = half_width_pointer(work)  # a segment has few pieces
    lanes = lane_count(rows)
    final = (min(np.int64(high) + 1, bottom) + 1) >> 1
    for i in range(max(np.int64(low), top) >> 1, final, lanes):
        if n > BATCH - lanes:
            widen(work, n, extents)
            n = np.int64(0)
        cell = load(rows, COUNT) + np.float32(i)
        enters, leaves = max(TWO * cell, low) - near, min(TWO * cell + TWO, high) - near
        a, b = across + enters * step, across + leaves * step
        first = floor(HALF * max(min(a, b) - HALF, np.float32(left)))
        last = floor(HALF * min(max(a, b) + HALF, np.float32(right - 1)))
        there = first <= last
        d, e = begin[2] + enters * (rise * slope), begin[2] + leaves * (rise * slope)
        last = where(there, last, np.float32(left >> 1))
        store(rows, FIRST + n, cell * jump + where(there, first, last) * beside)
        store(rows, LAST + n, cell * jump + last * beside)
        store(rows, NEAR + n, where(there, min(d, e), INF))
        store(rows, FAR + n, where(there, max(d, e), -INF))
        store(rows, JUMP + n, ZERO * d + beside)
        n += min(final - i, lanes)
    return n


@function
def widen(work, n, extents):
    """Widen the extents of the cells of the first n pieces of a batch."""
    for k in range(n):
        first, last, jump = np.int64(work[FIRST + k]), np.int64(work[LAST + k]), np.int64(work[JUMP + k])
        widen_cell(extents, first, work[NEAR + k], work[FAR + k])
        for cell in range(first + jump, last, jump):
            widen_cell(extents, cell, work[NEAR + k], work[FAR + k])
        widen_cell(extents, last, work[NEAR + k], work[FAR + k])


@device
def widen_cell(extents, number, nearest, farthest):
    """Widen the extents of a cell by depths, metres."""
    cell = np.uint64(number)
    extents[cell, NEAREST] = min(extents[cell, NEAREST], nearest)
    extents[cell, FARTHEST] = max(extents[cell, FARTHEST], farthest)
