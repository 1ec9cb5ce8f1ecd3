"""Segments of strands on an opacity map, a vector of them at a time, and the pieces that texels or cells cut them into.

A segment is cut at the borders of rows where it is steep on the map, else of columns. What its pieces follow
from is found for all segments of a vector at once: one after the other, the processor would guess wrong for each how
long it is and which way it leads.
"""

from __future__ import annotations

import numpy as np

from ....jit import device
from ....simd import floor, gather4, lane_count, load, pointer, sqrt, store, where
from .map_parts import TINY

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
FINEST = np.float32(64.0)
"""Most pieces that a texel is cut into where a segment leads away from the light."""
SEGMENTS = 16
"""Segments that are looked at together."""
BATCH = 256
"""Pieces of a batch: whole vectors."""

# Rows of numbers. First what is kept of segments: least and greatest place along the longer axis, texels, and that of
# the first vertex; there, place along the other axis, texels, and depth, metres; how much these change a texel; area a
# texel, texels; number of the first piece, how many there are, and how long each is, texels; 1 where it is steep.
LOW, HIGH, NEAR, ACROSS, DEPTH, STEP, RISE, AREA, BEGIN, PIECES, LENGTH, STEEP = (k * SEGMENTS for k in range(12))
NUMBERS = 12 * SEGMENTS
"""The numbers from 0 on."""
OUT = 13 * SEGMENTS
"""Where the rows of a batch begin."""


@device
def start(work):
    """Write the row `NUMBERS`."""
    for k in range(SEGMENTS):
        work[NUMBERS + k] = np.float32(k)


@device
def find_segments(work, kept, at, count, window, view, texels):
    """Write the rows of up to `SEGMENTS` segments between the vertices from number `at` on; return how many.

    kept: of `PartsInMap`; count: of segments from there on; texels: whether texels cut segments, and those that lead
    away from the light are cut into more pieces; else cells do, of two texels.
    """
    rows, points = pointer(work), pointer(kept)
    top, bottom, size = np.float32(window.top), np.float32(window.bottom), np.float32(window.width)
    for k in range(0, SEGMENTS, lane_count(rows)):
        lane = load(rows, NUMBERS + k)
        x0, y0, d0, _ = gather4(points, 4 * at, lane, 4, ZERO)
        x1, y1, d1, wide = gather4(points, 4 * at + 4, lane, 4, ZERO)
        none = ZERO * lane
        dx, dy, rise = x1 - x0, y1 - y0, d1 - d0
        steep = abs(dy) >= abs(dx)
        near, far = where(steep, y0, x0), where(steep, y1, x1)
        low, high = min(near, far), max(near, far)
        length = high - low
        # flat segments add to the rows of cells next to theirs, and a light may be so near that a segment is longer
        # than its map
        there = (wide >= ZERO) & (lane < np.float32(count)) & (length >= TINY) & (length <= size * np.float32(4.0))
        there = there & (max(y0, y1) >= top - ONE) & (min(y0, y1) <= bottom + ONE)
        parts = HALF + none
        if texels:
            away = abs(rise) * view.focal
            if not view.far > ZERO:
                away *= HALF * (ONE / d0 + ONE / d1)
            parts = where(away > length, floor(min(away / length, FINEST)) + ONE, ONE + none)
        first = parts * where(steep, top + none, none)
        end = parts * where(steep, bottom + none, size + none)
        first = max(floor(parts * low), first)
        end = min(floor(parts * high) + ONE, end)
        slope = ONE / (far - near)
        store(rows, LOW + k, low)
        store(rows, HIGH + k, high)
        store(rows, NEAR + k, near)
        store(rows, ACROSS + k, where(steep, x0, y0))
        store(rows, DEPTH + k, d0)
        store(rows, STEP + k, where(steep, dx, dy) * slope)
        store(rows, RISE + k, rise * slope)
        store(rows, AREA + k, wide * sqrt(dx * dx + dy * dy) / length)
        store(rows, BEGIN + k, first)
        store(rows, PIECES + k, where(there, max(end - first, ZERO), none))
        store(rows, LENGTH + k, ONE / parts)
        store(rows, STEEP + k, where(steep, ONE + none, none))
    return min(count, SEGMENTS)
