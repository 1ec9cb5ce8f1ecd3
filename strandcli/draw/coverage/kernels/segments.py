"""Consecutive segments of a strand, and the numbers with which each is drawn, computed in vector code."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ....simd import broadcast, deinterleave, floor, half_width_pointer, lane_count, load, sqrt, store, where
from .tiles import THIN

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
WIDE = np.float32(0.7)
"""Pixels. A wider segment is drawn as a ribbon; a cell of a thinner one touches at most three rows."""
POINT = np.float32(1e-6)
"""Pixels. A shorter segment draws nothing."""
ALONG_X, ALONG_Y = np.float32(1.0), np.float32(2.0)
"""Kinds of thin segments: more nearly parallel to x or to y; negative in the direction of decreasing x or y."""
RIBBON, BEHIND, NO_LENGTH = np.float32(0.0), np.float32(8.0), np.float32(9.0)
"""Kinds of other segments: wide, behind the eye, or shorter than `POINT`."""

SEGMENTS = 64
"""Greatest number of segments at once."""
ROW = SEGMENTS + 16
# Rows with one number a vertex: position on the screen, depth number, and width, pixels.
X, Y, DEPTH, WIDTH = (i * ROW for i in range(4))
# Rows with one number a segment; entry 0 is the segment before those loaded. Along: on the screen axis to which the
# segment is more nearly parallel, in the direction of travel; across: on the other axis.
# KIND: see above. BEGIN, END: its ends, along; FIRST, LAST: the cells that contain them. ACROSS: its beginning, across;
# SLOPE: rise across a pixel along. PER_LENGTH: one over its length along. HEIGHT: half the height of its band across.
# STRETCH: opacity × its length a pixel along. BEGIN_DEPTH, DEPTH_RISE: depth number at its beginning, and the increase
# to its end; NEAREST: the greater of both ends. BEGIN_WIDTH, WIDENING: width at its beginning, and the increase.
(
    KIND, BEGIN, END, FIRST, LAST, ACROSS, SLOPE, PER_LENGTH, HEIGHT, STRETCH, BEGIN_DEPTH, DEPTH_RISE, NEAREST,
    BEGIN_WIDTH, WIDENING,
) = (i * ROW for i in range(4, 19))  # fmt: skip
ROWS = 19
SEGMENT_ROWS = 15
"""Rows with one number a segment."""


@device
def load_vertices(points, widths, v, count, work):
    """Load `count` vertices from number v on into the rows X, Y, DEPTH and WIDTH; points: half-width pointer to (V, 3);
    widths: None if all are one pixel wide."""
    deinterleave(points, 3 * v, count, work, X, ROW)
    for k in range(np.uint64(count)):
        work[np.uint64(WIDTH) + k] = ONE if widths is None else widths[np.uint64(v) + k]


@inlined
def kind_of(dx, dy, near, wide):
    """Return the kind of segments from their extent (dx, dy), lesser depth number and greater width. Vectors."""
    du = where(abs(dx) >= abs(dy), dx, dy)
    kind = where(abs(dx) >= abs(dy), broadcast(dx, ALONG_X), ALONG_Y)
    kind = where(du > ZERO, kind, -kind)
    kind = where(wide > WIDE, RIBBON, kind)
    kind = where(abs(du) < POINT, NO_LENGTH, kind)
    return where(near > ZERO, kind, BEHIND)


@inlined
def along(kind, x, y):
    """Return the coordinate of points (x, y) along segments, in the direction of travel. Vectors."""
    u = where(abs(kind) <= ALONG_X, x, y)
    return where(kind > ZERO, u, -u)


@device
def measure_segments(work, count, opacity):
    """Store the rows from `KIND` on of the segments between count + 1 vertices."""
    rows = half_width_pointer(work)
    for k in range(0, count, lane_count(rows)):
        x0, y0, q0, w0 = load(rows, X + k), load(rows, Y + k), load(rows, DEPTH + k), load(rows, WIDTH + k)
        k += 1
        x1, y1, q1, w1 = load(rows, X + k), load(rows, Y + k), load(rows, DEPTH + k), load(rows, WIDTH + k)
        wide = max(w0, w1)
        kind = kind_of(x1 - x0, y1 - y0, min(q0, q1), wide)
        begin = along(kind, x0, y0)
        end = along(kind, x1, y1)
        flat = abs(kind) <= ALONG_X
        across = where(flat, y0, x0)
        per = ONE / (end - begin)
        slope = (where(flat, y1, x1) - across) * per
        stretch = sqrt(ONE + slope * slope)
        store(rows, KIND + k, kind)
        store(rows, BEGIN + k, begin)
        store(rows, END + k, end)
        store(rows, FIRST + k, floor(begin))
        store(rows, LAST + k, floor(end))
        store(rows, ACROSS + k, across)
        store(rows, SLOPE + k, slope)
        store(rows, PER_LENGTH + k, per)
        store(rows, HEIGHT + k, max(HALF * stretch * wide, THIN))
        store(rows, STRETCH + k, stretch * opacity)
        store(rows, BEGIN_DEPTH + k, q0)
        store(rows, DEPTH_RISE + k, q1 - q0)
        store(rows, NEAREST + k, max(q0, q1))
        store(rows, BEGIN_WIDTH + k, w0)
        store(rows, WIDENING + k, w1 - w0)


@inlined
def keep_last(work, k):
    """Copy segment number k to entry 0, that of the segment before those that are loaded next."""
    for row in range(SEGMENT_ROWS):
        work[KIND + row * ROW] = work[KIND + row * ROW + k]
