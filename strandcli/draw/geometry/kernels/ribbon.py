"""Ribbons, the wide segments of strands on the screen: ends, joints, width, and the depth of their round side."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined, parallel, prange
from ...common.kernels.numbers import HALF, INF, ONE, TWO, ZERO


class ScreenLines(NamedTuple):
    """Polylines on the screen: strand s owns the vertices first[s] … first[s + 1] − 1."""

    first: NDArray[np.int64]
    """(S + 1,)"""
    screen: NDArray[np.float32]
    """(V, 3) x to the right and y down, pixels, and the depth number, which grows toward the eye; 0 for a vertex that
    is not seen (see `strandcli.draw.view.kernels.project.points`)."""
    widths: NDArray[np.float32] | None
    """(V,) pixels; None: every line is one pixel wide."""


TINY = np.float32(1e-30)
MARGIN = np.float32(2.0)
"""Pixels that a strand extends beyond its vertices, besides its width."""
LEAST_Y, GREATEST_Y, WIDEST = 0, 1, 2
"""Columns of the extents of strands on the screen."""
COLUMNS = 3


class Ribbon(NamedTuple):
    """A wide segment on the screen, from vertex v − 1 to v, pixels; a: coordinate along the screen axis that it is more
    nearly parallel to, b: the other coordinate."""

    flat: bool
    """Whether a is x and b is y; else a is y and b is x."""
    a0: np.float32
    b0: np.float32
    """Beginning of its axis."""
    a1: np.float32
    b1: np.float32
    """End of its axis."""
    da: np.float32
    db: np.float32
    """Unit direction."""
    ma0: np.float32
    mb0: np.float32
    """Normal of the joint at its beginning (`mitre`)."""
    ma1: np.float32
    mb1: np.float32
    """Normal of the joint at its end."""
    w0: np.float32
    widening: np.float32
    """Width at its beginning, and increase of the width to its end."""
    q0: np.float32
    rise: np.float32
    """Depth number at its beginning, and increase of the depth number to its end."""
    per_length: np.float32
    """One over its length."""
    steep: np.float32
    """Increase of the depth number a pixel along it, for a length of at least half its width."""


@inlined
def make_ribbon(screen, v, w0, w1, flat, directed, joint0, joint1):
    """Return the `Ribbon` from vertex v − 1 to v, w0 to w1 pixels wide; screen: as in `ScreenLines`; flat: whether a is
    x; directed: from `direction`; joint0, joint1: from `mitre`, at its beginning and at its end."""
    x0, y0, q0 = screen[v - 1, 0], screen[v - 1, 1], screen[v - 1, 2]
    x1, y1, q1 = screen[v, 0], screen[v, 1], screen[v, 2]
    dx, dy, per_length = directed
    mx0, my0 = joint0
    mx1, my1 = joint1
    a0, b0, ma0, mb0 = (x0, y0, mx0, my0) if flat else (y0, x0, my0, mx0)
    a1, b1, ma1, mb1 = (x1, y1, mx1, my1) if flat else (y1, x1, my1, mx1)
    da, db = (dx, dy) if flat else (dy, dx)
    rise = q1 - q0
    steep = rise * min(per_length, TWO / max(w0, w1))
    return Ribbon(flat, a0, b0, a1, b1, da, db, ma0, mb0, ma1, mb1, w0, w1 - w0, q0, rise, per_length, steep)


@inlined
def direction(screen, v):
    """Return the unit direction from vertex v − 1 to v on the screen, and one over their distance."""
    dx = screen[v, 0] - screen[v - 1, 0]
    dy = screen[v, 1] - screen[v - 1, 1]
    per_length = ONE / math.sqrt(dx * dx + dy * dy)
    return dx * per_length, dy * per_length, per_length


@inlined
def cross_section(ribbon, per, slope, past):
    """Return the position t ∈ [0, 1] along a ribbon, its width and the coordinate b of its axis, where a column of
    pixels crosses the axis; a row of pixels if the ribbon is not flat.

    per: 1 / (a1 − a0); slope: (b1 − b0) / (a1 − a0); past: distance of the column's centre from a0.
    """
    t = min(max(past * per, ZERO), ONE)
    return t, ribbon.w0 + t * ribbon.widening, ribbon.b0 + slope * past


@inlined
def offsets_across(ribbon, t, width, a, b, depth_slope):
    """Return by how much the depth number of a strand's round side exceeds that of its axis at a point (a, b) of it:
    `forward` in front of the axis, and `tilt`, which is added at the edge toward greater b and subtracted at the other;
    both 0 for flat strands. t, width: from `cross_section`; depth_slope: `DepthSlope`.

    Away from the view's axis, a ray (u, v, 1) meets a slanted cylinder farther in front of its axis, and at different
    depths on its two sides. With q the depth number of the axis, half the width in pixels, g the increase of q a pixel
    along the strand over q, p and w, the components of (u, v) along and across the strand, and its direction
    E − g (u, v, 1), E = (dx, dy, 0),

        forward = q half √(1 − 2 g p + g² (1 + p² + w²)) / (1 + w²),   tilt = q half w (1 − g p) / (1 + w²):

    the first terms, in powers of half, of the greater root of |(z (u, v, 1) − P) × E| = radius in 1 / z.
    """
    x, y = (a, b) if ribbon.flat else (b, a)
    dx, dy = (ribbon.da, ribbon.db) if ribbon.flat else (ribbon.db, ribbon.da)
    per = depth_slope.per_depth * (ribbon.q0 + ribbon.rise * t) + depth_slope.constant
    if per <= ZERO:
        return ZERO, ZERO
    u = (x - depth_slope.axis_x) * depth_slope.per_depth
    v = (y - depth_slope.axis_y) * depth_slope.per_depth
    p = u * dx + v * dy
    w = v * dx - u * dy
    g = ribbon.steep / per
    slant = ONE - g * p
    scale = HALF * width * per / (ONE + w * w)
    turn = ONE if (dx if ribbon.flat else -dy) > ZERO else -ONE  # whether b grows toward (−dy, dx)
    return scale * np.sqrt(slant * slant + g * g * (ONE + w * w)), scale * w * slant * turn


@device
def mitre(screen, v, a, end, dx, dy, half, per):
    """Return the unit normal of the joint between a segment of direction d = (dx, dy) and its neighbour, from vertex v
    to v + 1 of the strand a … end − 1: halfway between their directions.

    It is d itself at a strand's end, and where a mitre does not fit: the strand turns by more than a right angle, or so
    much that the joint's line would extend beyond the other end of one of the segments. screen: as in `ScreenLines`;
    half: half the width at the joint, pixels; per: one over the length of the segment.
    """
    if v < a or v + 1 >= end or screen[v, 2] <= ZERO or screen[v + 1, 2] <= ZERO:
        return dx, dy
    ex = screen[v + 1, 0] - screen[v, 0]
    ey = screen[v + 1, 1] - screen[v, 1]
    size = ONE / math.sqrt(max(ex * ex + ey * ey, TINY))
    cosine = (ex * dx + ey * dy) * size
    # tan² of half the angle; both segments get the same result
    tangent = (ONE - cosine) / max(ONE + cosine, TINY)
    squat = half * max(size, per)
    if cosine <= ZERO or tangent * squat * squat > ONE:
        return dx, dy
    mx = ex * size + dx
    my = ey * size + dy
    size = ONE / math.sqrt(mx * mx + my * my)
    return mx * size, my * size


@parallel
def find_on_screen(first, screen, widths, width, out):
    """Write the range of y that each strand can cover on the screen, and its greatest width.

    first (S + 1,) int64; screen (V, 3): as in `ScreenLines`; widths (V,): likewise, or (0,): all are one pixel; width:
    of the picture; out (S, COLUMNS) float32: least and greatest y, inf and −inf for a strand that is not on the
    screen; the width.
    """
    for s in prange(first.shape[0] - 1):
        low, high, left, right = INF, -INF, INF, -INF
        widest = ONE if widths.shape[0] == 0 else ZERO
        for v in range(first[s], first[s + 1]):
            if widths.shape[0] > 0:
                widest = max(widest, widths[v])
            if screen[v, 2] > ZERO:
                left, right = min(left, screen[v, 0]), max(right, screen[v, 0])
                low, high = min(low, screen[v, 1]), max(high, screen[v, 1])
        margin = MARGIN + widest  # a mitre extends by up to half a width times the square root of two
        there = (right + margin >= ZERO) & (left - margin < np.float32(width))
        out[s, LEAST_Y] = low - margin if there else INF
        out[s, GREATEST_Y] = high + margin if there else -INF
        out[s, WIDEST] = widest
