"""Nearest and farthest depths of strands in the cells of an opacity map, a batch at a time.

Vectors find which cells each piece of a segment comes to, and a last loop widens their extents, which would wait for
the length of each segment otherwise.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, function
from ....simd import floor, half_width_pointer, lane_count, load, store, where
from .map_segments import (
    ACROSS,
    BATCH,
    BEGIN,
    DEPTH,
    HIGH,
    LOW,
    NEAR,
    NUMBERS,
    OUT,
    PIECES,
    RISE,
    STEEP,
    STEP,
)
from .minmax import FARTHEST, NEAREST

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
INF = np.float32(np.inf)
# Rows of a batch: numbers of the first and the last cell of a piece, nearest and farthest depth, metres; distance of
# numbers of cells beside each other.
FIRST, LAST, NEAR_DEPTH, FAR_DEPTH, JUMP = (OUT + row * BATCH for row in range(5))


@device
def collect_cells(work, n, segments, window, extents):
    """Add the pieces of segments to a batch of n; return how many it holds then. A full batch widens the extents.

    work: rows of `map_segments`.
    """
    rows = half_width_pointer(work)  # a segment has few pieces
    lanes = lane_count(rows)
    half = np.float32(window.width >> 1)
    numbers = load(rows, NUMBERS)
    none = ZERO * numbers
    for s in range(segments):
        pieces = np.int64(work[PIECES + s])
        low, high, near, across = work[LOW + s], work[HIGH + s], work[NEAR + s], work[ACROSS + s]
        step, depth, rise = work[STEP + s], work[DEPTH + s], work[RISE + s]
        steep = work[STEEP + s] > ZERO
        jump, beside = (half, ONE) if steep else (ONE, half)
        left = ZERO if steep else np.float32(window.top)
        right = np.float32(window.width if steep else window.bottom) - ONE
        for i in range(0, pieces, lanes):
            if n > BATCH - lanes:
                widen(work, n, extents)
                n = np.int64(0)
            cell = numbers + (work[BEGIN + s] + np.float32(i))
            enters, leaves = max(TWO * cell, low) - near, min(TWO * cell + TWO, high) - near
            a, b = across + enters * step, across + leaves * step
            first = floor(HALF * max(min(a, b) - HALF, left))
            last = floor(HALF * min(max(a, b) + HALF, right))
            there = first <= last
            last = where(there, last, HALF * left + none)
            d, e = depth + enters * rise, depth + leaves * rise
            store(rows, FIRST + n, cell * jump + where(there, first, last) * beside)
            store(rows, LAST + n, cell * jump + last * beside)
            store(rows, NEAR_DEPTH + n, where(there, min(d, e), INF + none))
            store(rows, FAR_DEPTH + n, where(there, max(d, e), none - INF))
            store(rows, JUMP + n, beside + none)
            n += min(pieces - i, lanes)
    return n


@function
def widen(work, n, extents):
    """Widen the extents of the cells of the first n pieces of a batch."""
    for k in range(n):
        first, last, jump = np.int64(work[FIRST + k]), np.int64(work[LAST + k]), np.int64(work[JUMP + k])
        widen_cell(extents, first, work[NEAR_DEPTH + k], work[FAR_DEPTH + k])
        for cell in range(first + jump, last, jump):
            widen_cell(extents, cell, work[NEAR_DEPTH + k], work[FAR_DEPTH + k])
        widen_cell(extents, last, work[NEAR_DEPTH + k], work[FAR_DEPTH + k])


@device
def widen_cell(extents, number, nearest, farthest):
    """Widen the extents of a cell by depths, metres."""
    cell = np.uint64(number)
    extents[cell, NEAREST] = min(extents[cell, NEAREST], nearest)
    extents[cell, FARTHEST] = max(extents[cell, FARTHEST], farthest)
