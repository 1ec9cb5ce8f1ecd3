"""Nearest and farthest depths of strands in the cells of an opacity map.

Vectors find which cells a piece of each segment comes to. Most pieces widen no extents, for of many strands in a cell
few are its nearest or farthest so far: which do is known before any is written.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, function, inlined
from ....simd import any_lane, floor, gather2, lane_count, movemask, pointer, store, where
from .map_segments import OUT, SEGMENTS, segments_at
from .minmax import FARTHEST, NEAREST

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
START = np.float32(NEAREST)
NO_BITS, BIT = np.uint64(0), np.uint64(1)
EXPONENT_BIAS, MANTISSA_BITS = 127, 23
"""What is added to the exponent of a number in single precision, and bits below that."""
# Rows of a vector of pieces: number of a cell, nearest and farthest depth, metres.
CELL, NEAR_DEPTH, FAR_DEPTH = (OUT + row * SEGMENTS for row in range(3))


@device
def widen(work, count, window, view, extents):
    """Widen the extents of cells by the first segments of a run, so many.

    work: rows of `map_segments`.
    """
    rows, heads = pointer(work), pointer(extents)
    half, size = np.float32(window.width >> 1), np.float32(window.width)
    top, bottom = np.float32(window.top), np.float32(window.bottom)
    for k in range(0, count, lane_count(rows)):
        low, high, near, across, depth, step, rise, _, begin, pieces, _, steep = segments_at(
            rows, k, count, window, view, False
        )
        none = ZERO * low
        jump, beside = where(steep, half + none, ONE + none), where(steep, ONE + none, half + none)
        left, right = where(steep, none, top + none), where(steep, size + none, bottom + none) - ONE
        part = none
        while any_lane(part < pieces):
            cell = begin + part
            enters, leaves = max(TWO * cell, low) - near, min(TWO * cell + TWO, high) - near
            a, b = across + enters * step, across + leaves * step
            first = floor(HALF * max(min(a, b) - HALF, left))
            last = floor(HALF * min(max(a, b) + HALF, right))
            there = (part < pieces) & (first <= last)
            d, e = depth + enters * rise, depth + leaves * rise
            nearest, farthest = min(d, e), max(d, e)
            row = cell * jump
            widen_by(work, heads, extents, there, row + first * beside, nearest, farthest)
            first += ONE
            while any_lane(there & (first <= last)):
                there = there & (first <= last)
                widen_by(work, heads, extents, there, row + first * beside, nearest, farthest)
                first += ONE
            part += ONE


@inlined
def widen_by(work, heads, extents, there, cell, nearest, farthest):
    """Widen the extents of a vector of cells, those that are there, by depths, metres; heads: `pointer` to extents."""
    rows = pointer(work)
    begins, ends = gather2(heads, 0, where(there, cell, ZERO), 2, START)
    wider = movemask(there & ((nearest < begins) | (farthest > ends)))
    if wider != NO_BITS:
        store(rows, CELL, cell)
        store(rows, NEAR_DEPTH, nearest)
        store(rows, FAR_DEPTH, farthest)
        widen_cells(work, wider, extents)


@function
def widen_cells(work, wider, extents):
    """Widen the extents of the cells in the row `CELL` of which `wider` has a bit."""
    while wider != NO_BITS:
        rest = wider & (wider - BIT)
        k = (np.float32(wider ^ rest).view(np.int32) >> MANTISSA_BITS) - EXPONENT_BIAS  # of the lowest bit
        cell = np.uint64(work[CELL + k])
        extents[cell, NEAREST] = min(extents[cell, NEAREST], work[NEAR_DEPTH + k])
        extents[cell, FARTHEST] = max(extents[cell, FARTHEST], work[FAR_DEPTH + k])
        wider = rest
