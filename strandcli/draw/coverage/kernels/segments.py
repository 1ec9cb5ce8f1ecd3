"""Pieces of a strand in a row, and what of each is needed to draw it: one loop over them, which becomes vector code."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ....simd import broadcast, deinterleave, floor, half_width_pointer, lane_count, load, sqrt, store, where
from .tiles import THIN

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
WIDE = np.float32(0.7)
"""Pixels. Narrower than that, a cell of a piece touches three rows at the most."""
POINT = np.float32(1e-6)
"""Pixels. What is shorter is a point, and draws nothing."""
ALONG_X, ALONG_Y = np.float32(1.0), np.float32(2.0)
RIBBON, BEHIND, NO_WAY = np.float32(0.0), np.float32(8.0), np.float32(9.0)
"""Ways of pieces that follow no axis: wide, behind the eye, or points."""

PIECES = 64
ROW = PIECES + 16
# Rows of numbers, one a vertex: place on the screen, depth number and width in pixels. Then one a piece, of which the
# first is the one before these: how it goes (`way_of`); where it begins and ends along the axis that it follows, in the
# direction of travel, and in which cells; where it begins across; what it rises across a pixel along; one over its
# length along; half the height of its band; opacity times its length a pixel along; depth number at its beginning, how
# much that grows, and the greater one; width at its beginning, and how much that grows.
X, Y, DEPTH, WIDTH = (i * ROW for i in range(4))
WAY, BEGIN, END, FIRST, LAST, ACROSS, SLOPE, PER, HEIGHT, STRETCH, Q, DEEPER, NEAREST, W, WIDER = (
    i * ROW for i in range(4, 19)
)  # fmt: skip
ROWS = 19
SEGMENT_ROWS = 15
"""Rows with one number a segment."""


@device
def load_vertices(points, widths, v, count, pieces):
    """Vertices from number v on of points, a half-width pointer to (V, 3), into the rows X, Y, DEPTH and WIDTH; widths
    None: all are a pixel wide."""
    deinterleave(points, 3 * v, count, pieces, X, ROW)
    for k in range(np.uint64(count)):
        pieces[np.uint64(WIDTH) + k] = ONE if widths is None else widths[np.uint64(v) + k]


@inlined
def way_of(dx, dy, near, wide):
    """How pieces go over (dx, dy): `ALONG_X` or `ALONG_Y`, negative against the axis; or `RIBBON` if their greater
    width is more than `WIDE`, `BEHIND` if the lesser depth number is none, `NO_WAY`."""
    du = where(abs(dx) >= abs(dy), dx, dy)
    way = where(abs(dx) >= abs(dy), broadcast(dx, ALONG_X), ALONG_Y)
    way = where(du > ZERO, way, -way)
    way = where(wide > WIDE, RIBBON, way)
    way = where(abs(du) < POINT, NO_WAY, way)
    return where(near > ZERO, way, BEHIND)


@inlined
def along(way, x, y):
    """A place along the axis that pieces follow, in the direction of travel."""
    u = where(abs(way) <= ALONG_X, x, y)
    return where(way > ZERO, u, -u)


@device
def measure_segments(pieces, count, opacity):
    """What `fragments` needs of the segments between count + 1 vertices: the rows from WAY on."""
    rows = half_width_pointer(pieces)
    for k in range(0, count, lane_count(rows)):
        x0, y0, q0, w0 = load(rows, X + k), load(rows, Y + k), load(rows, DEPTH + k), load(rows, WIDTH + k)
        k += 1
        x1, y1, q1, w1 = load(rows, X + k), load(rows, Y + k), load(rows, DEPTH + k), load(rows, WIDTH + k)
        wide = max(w0, w1)
        way = way_of(x1 - x0, y1 - y0, min(q0, q1), wide)
        begin = along(way, x0, y0)
        end = along(way, x1, y1)
        flat = abs(way) <= ALONG_X
        across = where(flat, y0, x0)
        per = ONE / (end - begin)
        slope = (where(flat, y1, x1) - across) * per
        stretch = sqrt(ONE + slope * slope)
        store(rows, WAY + k, way)
        store(rows, BEGIN + k, begin)
        store(rows, END + k, end)
        store(rows, FIRST + k, floor(begin))
        store(rows, LAST + k, floor(end))
        store(rows, ACROSS + k, across)
        store(rows, SLOPE + k, slope)
        store(rows, PER + k, per)
        store(rows, HEIGHT + k, max(HALF * stretch * wide, THIN))
        store(rows, STRETCH + k, stretch * opacity)
        store(rows, Q + k, q0)
        store(rows, DEEPER + k, q1 - q0)
        store(rows, NEAREST + k, max(q0, q1))
        store(rows, W + k, w0)
        store(rows, WIDER + k, w1 - w0)


@inlined
def keep_last(pieces, k):
    """Keep segment number k as the one before those that come next."""
    for row in range(SEGMENT_ROWS):
        pieces[WAY + row * ROW] = pieces[WAY + row * ROW + k]
