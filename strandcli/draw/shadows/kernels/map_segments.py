"""Segments of strands on an opacity map, a vector of them at a time, and the pieces that texels or cells cut them into.

Parts of strands often have fewer segments than a vector has lanes, so their vertices come one part after the other into
a run, of which vectors are full. No segment ends at the first vertex of a part, so none leads from one part to another.

A segment is cut at the borders of rows where it is steep on the map, else of columns. What its pieces follow
from is found for all segments of a vector at once: one after the other, the processor would guess wrong for each how
long it is and which way it leads.
"""

from __future__ import annotations

import numpy as np

from ....jit import device
from ....simd import floor, lane_count, load, load_quadruples, pointer, sqrt, store, where
from ...common.kernels.numbers import HALF, ONE, STEPS, ZERO
from .map_parts import TINY

FINEST = np.float32(64.0)
"""Most pieces that a texel is cut into where a segment leads away from the light."""
PER_TEXEL = np.float32(0.5)
"""Pieces for each texel of depth: where a segment leads away from the light by more than two in a texel's width."""
SEGMENTS = 16
"""Segments that are looked at together."""
RUN = 64
"""Segments of a run from which on they are drawn, and most vertices that come into it at once: whole vectors."""
BATCH = 256
"""Pieces of a batch: whole vectors."""

# Rows of numbers. First what is kept of segments: least and greatest place along the longer axis, texels, and that of
# the first vertex; there, place along the other axis, texels, and depth, metres; how much these change a texel; area a
# texel, texels; number of the first piece, how many there are, and how long each is, texels; 1 where it is steep.
LOW, HIGH, NEAR, ACROSS, DEPTH, STEP, RISE, AREA, BEGIN, PIECES, LENGTH, STEEP = (k * SEGMENTS for k in range(12))
VERTICES = 12 * SEGMENTS
"""The vertices of a run, as in `PartsInMap.kept`."""
OUT = VERTICES + 4 * (2 * RUN + SEGMENTS)
"""Where the rows of a batch begin."""


@device
def append(work, held, kept, begin, count):
    """Bring up to `RUN` vertices from number `begin` on into a run that holds some; return how many it holds then."""
    rows, points = pointer(work), pointer(kept)
    for at in range(0, 4 * count, lane_count(rows)):
        store(rows, VERTICES + 4 * held + at, load(points, 4 * begin + at))
    return held + count


@device
def leave_out(work, held, segments):
    """Take segments, whole vectors of them, off the beginning of a run; return how many vertices it holds then."""
    rows = pointer(work)
    for at in range(0, 4 * (held - segments), lane_count(rows)):
        store(rows, VERTICES + at, load(rows, VERTICES + 4 * segments + at))
    return held - segments


@device
def find_segments(work, begin, count, window, view):
    """Write the rows of up to `SEGMENTS` segments of a run, which has so many, from number `begin` on; return how many.

    Texels cut segments; those that lead away from the light are cut into more pieces."""
    rows = pointer(work)
    top, bottom, size = np.float32(window.top), np.float32(window.bottom), np.float32(window.width)
    lane = load(pointer(STEPS), 0)
    none = ZERO * lane
    for k in range(0, SEGMENTS, lane_count(rows)):
        at = VERTICES + 4 * (begin + k)
        x0, y0, d0, _ = load_quadruples(rows, at)
        x1, y1, d1, wide = load_quadruples(rows, at + 4)
        dx, dy, rise = x1 - x0, y1 - y0, d1 - d0
        steep = abs(dy) >= abs(dx)
        near, far = where(steep, y0, x0), where(steep, y1, x1)
        low, high = min(near, far), max(near, far)
        length = high - low
        # flat segments add to the rows of cells next to theirs, and a light may be so near that a segment is longer
        # than its map
        there = (wide >= ZERO) & (lane < np.float32(count - begin - k))
        there = there & (length >= TINY) & (length <= size * np.float32(4.0))
        there = there & (max(y0, y1) >= top - ONE) & (min(y0, y1) <= bottom + ONE)
        away = abs(rise) * (PER_TEXEL * view.focal)
        if not view.far > ZERO:
            away *= HALF * (ONE / d0 + ONE / d1)
        parts = where(away > length, floor(min(away / length, FINEST)) + ONE, ONE + none)
        first = max(floor(parts * low), parts * where(steep, top + none, none))
        end = min(floor(parts * high) + ONE, parts * where(steep, bottom + none, size + none))
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
    return min(count - begin, SEGMENTS)
