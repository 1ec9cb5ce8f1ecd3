"""Consecutive segments of a strand, and the numbers with which each is drawn, computed in vector code."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ....simd import (
    any_lane,
    broadcast,
    deinterleave,
    floor,
    gather,
    half_width_pointer,
    lane_count,
    load,
    sqrt,
    store,
    where,
)
from ...common.kernels.numbers import HALF, ONE, STEPS, ZERO
from .tiles import OF_TILE, THIN, window_of

WIDE = np.float32(0.7)
"""Pixels. Segments that are no wider are thin whatever their slope; wider ones have the height of their band from point
to point, and the depth of their round side."""
TALL = np.float32(1.8)
"""Pixels. A segment whose band is taller within a cell is drawn as a ribbon; that of a thin one touches at most three
rows of a cell, with slopes as `cells` has them."""
POINT = np.float32(1e-6)
"""Pixels. A shorter segment draws nothing."""
ALONG_X, ALONG_Y = np.float32(1.0), np.float32(2.0)
"""Kinds of thin segments: more nearly parallel to x or to y; negative in the direction of decreasing x or y."""
RIBBON, BEHIND, NO_LENGTH = np.float32(0.0), np.float32(8.0), np.float32(9.0)
"""Kinds of other segments: wide, behind the eye, or shorter than `POINT`."""

REACH = np.float32(1.1)
"""Pixels that a segment extends beyond its ends in addition to its width: its rise within a cell."""
ROUND = np.float32(1.51)
"""Greatest share of a half width in front of an axis, `forward` 1 and `tilt` 1/2, and something for rounding."""
MITRE = np.float32(0.7072)
"""Share of its width that a segment extends beyond its ends: half the width over the cosine of a mitre's slant."""
SEGMENTS = 64
"""Greatest number of segments at once."""
ROW = SEGMENTS + 16
# Rows with one number a vertex: position on the screen, depth number, and width, pixels.
X, Y, DEPTH, WIDTH = (i * ROW for i in range(4))
# Rows with one number a segment; entry 0 is the segment before those loaded. Along: on the screen axis to which the
# segment is more nearly parallel, in the direction of travel; across: on the other axis.
# KIND: see above. BEGIN, END: its ends, along; FIRST, LAST: the cells that contain them. ACROSS: its beginning, across;
# SLOPE: rise across a pixel along. PER_LENGTH: one over its length along. HEIGHT, GROWTH: half the height of its band
# across at its beginning, and the increase to its end.
# STRETCH: opacity × its length a pixel along. BEGIN_DEPTH, DEPTH_RISE: depth number at its beginning, and the increase
# to its end; NEAREST: a bound on that of all it shows. BEGIN_WIDTH, WIDENING: width at its beginning, and the increase.
# HIDDEN: depth number behind which nothing is visible where it lies in the tile.
(
    KIND, BEGIN, END, FIRST, LAST, ACROSS, SLOPE, PER_LENGTH, HEIGHT, STRETCH, BEGIN_DEPTH, DEPTH_RISE, NEAREST,
    BEGIN_WIDTH, WIDENING, HIDDEN, GROWTH,
) = (i * ROW for i in range(4, 21))  # fmt: skip
JOINED = 21 * ROW
"""Where the rows of `measure_joints` begin."""
ROWS = 31
SEGMENT_ROWS = 17
"""Rows with one number a segment."""


@device
def load_vertices(points, widths, v, count, work):
    """Load `count` vertices from number v on into the rows X, Y, DEPTH and WIDTH; points: half-width pointer to (V, 3);
    widths: None if all are one pixel wide."""
    deinterleave(points, 3 * v, count, work, X, ROW)
    for k in range(np.uint64(count)):
        work[np.uint64(WIDTH) + k] = ONE if widths is None else widths[np.uint64(v) + k]


@inlined
def kind_of(dx, dy, near, wide, widths):
    """Return the kind of segments from their extent (dx, dy), lesser depth number and greater width, vectors; widths:
    of all, or None, where each is a pixel wide and drawn as a ribbon."""
    du = where(abs(dx) >= abs(dy), dx, dy)
    kind = where(abs(dx) >= abs(dy), broadcast(dx, ALONG_X), ALONG_Y)
    kind = where(du > ZERO, kind, -kind)
    if widths is None:
        kind = broadcast(dx, RIBBON)
    elif any_lane(wide > WIDE):  # in many pictures none is
        # h + s / 2 of `cells`, times twice the extent along
        tall = wide * sqrt(dx * dx + dy * dy) + min(abs(dx), abs(dy)) > TALL * max(abs(dx), abs(dy))
        kind = where((wide > WIDE) & tall, RIBBON, kind)
    kind = where(abs(du) < POINT, NO_LENGTH, kind)
    return where(near > ZERO, kind, BEHIND)


@inlined
def along(kind, x, y):
    """Return the coordinate of points (x, y) along segments, in the direction of travel. Vectors."""
    u = where(abs(kind) <= ALONG_X, x, y)
    return where(kind > ZERO, u, -u)


@inlined
def reach_of(kind, wide):
    """Return how far segments extend beyond their ends in x and in y; wide: their greater width. Vectors."""
    reach = REACH + MITRE * wide
    # along its axis, a thin segment does not extend beyond the cells of its ends
    across_x = where(abs(abs(kind) - ALONG_X) <= ZERO, ZERO, reach)
    across_y = where(abs(abs(kind) - ALONG_Y) <= ZERO, ZERO, reach)
    return across_x, across_y


@inlined
def nearest_of(q0, q1, wide, per, far, depth_slope):
    """Return bounds on the depth numbers of all that segments show: of wide ones, with that on `forward` and `tilt` of
    `geometry.kernels.ribbon.offsets_across`. Vectors.

    q0, q1: depth numbers of their ends; wide: greater width; per: one over the length along; far: sum of the distances
    from the view's axis in x and in y, pixels, of a place in the tile.
    """
    near = max(q0, q1)
    half = HALF * wide
    aside = (far + wide) * depth_slope.per_depth  # the axis may lie outside the tile
    steep = abs(q1 - q0) * min(half * abs(per), ONE) * (ONE + aside)
    round_ = ROUND * (half * max(depth_slope.per_depth * near + depth_slope.constant, ZERO) + steep)
    return where(wide > WIDE, near + round_, near)


@inlined
def from_axis(left, right, top, bottom, depth_slope):
    """Return the sum of the greatest distances from the view's axis in x and in y of a place within these sides,
    pixels."""
    x, y = depth_slope.axis_x, depth_slope.axis_y
    return max(abs(left - x), abs(right - x)) + max(abs(top - y), abs(bottom - y))


@inlined
def measure_segments(work, widths, count, opacity, left, top, far, depth_slope, windows):
    """Store the rows from `KIND` on of the segments between count + 1 vertices; return whether any may be wide.

    widths: as in `kind_of`; opacity: of the material; left, top: of the tile; far, depth_slope: as in `nearest_of`;
    windows: as in `tiles.find_windows`.
    """
    rows = half_width_pointer(work)
    depths = half_width_pointer(windows)
    ribbons = False
    for k in range(0, count, lane_count(rows)):
        x0, y0, q0, w0 = load(rows, X + k), load(rows, Y + k), load(rows, DEPTH + k), load(rows, WIDTH + k)
        k += 1
        x1, y1, q1, w1 = load(rows, X + k), load(rows, Y + k), load(rows, DEPTH + k), load(rows, WIDTH + k)
        wide = max(w0, w1)
        kind = kind_of(x1 - x0, y1 - y0, min(q0, q1), wide, widths)
        begin = along(kind, x0, y0)
        end = along(kind, x1, y1)
        flat = abs(kind) <= ALONG_X
        across = where(flat, y0, x0)
        per = ONE / (end - begin)
        slope = (where(flat, y1, x1) - across) * per
        stretch = sqrt(ONE + slope * slope)
        ribbons |= any_lane(abs(kind) < HALF)
        store(rows, KIND + k, kind)
        store(rows, BEGIN + k, begin)
        store(rows, END + k, end)
        store(rows, FIRST + k, floor(begin))
        store(rows, LAST + k, floor(end))
        store(rows, ACROSS + k, across)
        store(rows, SLOPE + k, slope)
        store(rows, PER_LENGTH + k, per)
        # of narrow ones, the greater height all along is near enough
        store(rows, HEIGHT + k, where(wide > WIDE, HALF * stretch * w0, max(HALF * stretch * wide, THIN)))
        store(rows, GROWTH + k, where(wide > WIDE, HALF * stretch * (w1 - w0), ZERO))
        store(rows, STRETCH + k, stretch * opacity)
        # the middle of its round side, as if it were parallel to the picture
        ahead = HALF * (HALF * (w0 + w1)) * max(depth_slope.per_depth * q0 + depth_slope.constant, ZERO)
        store(rows, BEGIN_DEPTH + k, q0 + where(wide > WIDE, ahead, ZERO))
        store(rows, DEPTH_RISE + k, q1 - q0)
        store(rows, NEAREST + k, nearest_of(q0, q1, wide, per, far, depth_slope))
        store(rows, BEGIN_WIDTH + k, w0)
        store(rows, WIDENING + k, w1 - w0)
        reach_x, reach_y = reach_of(kind, wide)
        x0, x1, y0, y1 = x0 - left, x1 - left, y0 - top, y1 - top
        here = window_of(
            min(x0, x1) - reach_x, max(x0, x1) + reach_x, min(y0, y1) - reach_y, max(y0, y1) + reach_y, OF_TILE
        )  # fmt: skip
        store(rows, HIDDEN + k, gather(depths, 0, here, 1, ZERO))
    return ribbons


TINY = np.float32(1e-30)
# Rows of the vertices from the one before those loaded on: position on the screen and depth number; then those of
# segments, as in `segments`: unit direction, one over the length on the screen, and the normals of the joints at both
# ends.
NEAR_X, NEAR_Y, NEAR_DEPTH, DX, DY, PER_SIZE, MX0, MY0, MX1, MY1 = (JOINED + i * ROW for i in range(10))


@inlined
def measure_joints(points, base, count, begin, end, work):
    """Store the rows from `DX` on of the segments that `measure_segments` has measured.

    points: half-width pointer to (V, 3); base: last vertex of the first of the `count` segments, of the strand of the
    vertices begin … end − 1; work: its rows.
    """
    rows, numbers = half_width_pointer(work), half_width_pointer(STEPS)
    first = max(base - 2, begin)
    deinterleave(points, 3 * first, min(base + count + 1, end) - first, work, NEAR_X + first - (base - 2), ROW)
    before, after = np.float32(begin - base + 2), np.float32(end - base - 1)
    for k in range(0, count, lane_count(rows)):
        x0, y0, x1, y1 = (
            load(rows, NEAR_X + k + 1),
            load(rows, NEAR_Y + k + 1),
            load(rows, NEAR_X + k + 2),
            load(rows, NEAR_Y + k + 2),
        )
        there0, there1 = load(rows, NEAR_DEPTH + k + 1) > ZERO, load(rows, NEAR_DEPTH + k + 2) > ZERO
        number = load(numbers, k)
        there0 = there0 & (load(rows, NEAR_DEPTH + k) > ZERO) & ~(number < before)
        there1 = there1 & (load(rows, NEAR_DEPTH + k + 3) > ZERO) & (number < after)
        dx, dy = x1 - x0, y1 - y0
        per = ONE / sqrt(dx * dx + dy * dy)
        dx, dy = dx * per, dy * per
        half0, half1 = HALF * load(rows, WIDTH + k), HALF * load(rows, WIDTH + k + 1)
        mx0, my0 = joint(x0 - load(rows, NEAR_X + k), y0 - load(rows, NEAR_Y + k), dx, dy, half0, per, there0)
        mx1, my1 = joint(load(rows, NEAR_X + k + 3) - x1, load(rows, NEAR_Y + k + 3) - y1, dx, dy, half1, per, there1)
        k += 1
        store(rows, DX + k, dx)
        store(rows, DY + k, dy)
        store(rows, PER_SIZE + k, per)
        store(rows, MX0 + k, mx0)
        store(rows, MY0 + k, my0)
        store(rows, MX1 + k, mx1)
        store(rows, MY1 + k, my1)


@inlined
def joint(ex, ey, dx, dy, half, per, there):
    """Return `mitre` of segments of direction (dx, dy) and their neighbours, which extend by (ex, ey); there: whether
    they have one in front of the eye. Vectors."""
    size = ONE / sqrt(max(ex * ex + ey * ey, TINY))
    cosine = (ex * dx + ey * dy) * size
    tangent = (ONE - cosine) / max(ONE + cosine, TINY)
    squat = half * max(size, per)
    fits = there & ~((cosine <= ZERO) | (tangent * squat * squat > ONE))
    mx = ex * size + dx
    my = ey * size + dy
    size = ONE / sqrt(mx * mx + my * my)
    return where(fits, mx * size, dx), where(fits, my * size, dy)
