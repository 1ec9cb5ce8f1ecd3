"""What lies between the light and a line: the places of a piece of a strand that bands of others darken.

Bands are listed in the cells of a grid over the light's view (`grid`), nearest first. A line is followed from cell to
cell. Within a cell the list ends for it where bands lie behind it, and the inequalities are one loop over the bands,
which becomes vector code.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ...common.kernels.view_columns import (
    AXIS_X,
    AXIS_Y,
    DEPTH_RANGE,
    FOCAL,
    FORWARD_SHIFT,
    FORWARD_X,
    FORWARD_Y,
    FORWARD_Z,
    NEAR_PLANE,
    PERSPECTIVE,
    RIGHT_SHIFT,
    RIGHT_X,
    RIGHT_Y,
    RIGHT_Z,
    UP_SHIFT,
    UP_X,
    UP_Y,
    UP_Z,
)
from .grid import (
    ALONG,
    ALONG_X,
    ALONG_Y,
    ASIDE,
    ASIDE_X,
    ASIDE_Y,
    DEPTH,
    GROWS,
    LOW,
    ROWS,
    WIDENS,
    WIDTH,
    columns,
    nearness,
    whole,
)
from .interval_bits import WORD, all_dark, darken

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
BATCH = 64
"""Bands that are held against a line at once."""


@device
def piece(world, p, v, views, one, size, cells, begin, keys, lines, low, high, veil, bias, cuts, dark):
    """Darken the piece after vertex v, from point p of `world` to the next, by what one view shows in front of it, but
    not by the pieces after the vertices from `low` to `high`."""
    x0, y0, q0 = seen(world, p, views, one, bias)
    x1, y1, q1 = seen(world, p + 1, views, one, bias)
    if q0 <= ZERO or q1 <= ZERO:
        return
    dx = x1 - x0
    dy = y1 - y0
    dq = q1 - q0
    # of a cube's sides none sees what is another's
    edge = np.float32(1.5) if views.shape[0] > 1 else ZERO
    since, until = between(ZERO, ONE, x0 - edge, dx)
    since, until = between(since, until, np.float32(size) - edge - x0, -dx)
    since, until = between(since, until, y0 - edge, dy)
    since, until = between(since, until, np.float32(size) - edge - y0, -dy)
    if since >= until:
        return
    for row in range(whole(min(y0, y1), 0, size), whole(max(y0, y1) + ONE, 0, size)):
        left, right = columns(x0, y0, x1, y1, ZERO, row)
        above, under = between(since, until, y0 - np.float32(row), dy)
        above, under = between(above, under, np.float32(row + 1) - y0, -dy)
        for column in range(whole(left, 0, size), whole(right + ONE, 0, size)):
            a, b = between(above, under, x0 - np.float32(column), dx)
            a, b = between(a, b, np.float32(column + 1) - x0, -dx)
            cell = cells + row * size + column
            if a < b and begin[cell] < begin[cell + 1]:
                x = x0 - np.float32(column)
                y = y0 - np.float32(row)
                cross(
                    x + a * dx, y + a * dy, q0 + a * dq, x + b * dx, y + b * dy, q0 + b * dq, a, b, begin[cell],
                    begin[cell + 1], keys, lines, v, low, high, veil, cuts, dark,
                )  # fmt: skip


@inlined
def seen(world, v, views, one, bias):
    """Where a view shows a vertex, in cells, and its depth number; 0 where it does not."""
    x = views[one, RIGHT_X] * world[v, 0] + views[one, RIGHT_Y] * world[v, 1] + views[one, RIGHT_Z] * world[v,
    2] + views[one, RIGHT_SHIFT]
    y = views[one, UP_X] * world[v, 0] + views[one, UP_Y] * world[v, 1] + views[one, UP_Z] * world[v, 2] + views[one,
    UP_SHIFT]
    z = views[one, FORWARD_X] * world[v, 0] + views[one, FORWARD_Y] * world[v, 1] + views[one, FORWARD_Z] * world[v,
    2] + views[one, FORWARD_SHIFT]
    if not z >= views[one, NEAR_PLANE]:
        return ZERO, ZERO, ZERO
    near = max(z - bias, views[one, NEAR_PLANE])
    if views[one, PERSPECTIVE] > ZERO:
        scale = views[one, FOCAL] / z
        q = ONE / near
    else:
        scale = views[one, FOCAL]
        q = max(ONE - (near - views[one, NEAR_PLANE]) / views[one, DEPTH_RANGE], TINY)
    return views[one, AXIS_X] + scale * x, views[one, AXIS_Y] - scale * y, q


@inlined
def between(a, b, value, slope):
    """The part of a <= t <= b where value + slope · t >= 0; where there is none it ends before it
    begins, or there."""
    root = -value / slope  # where the slope is 0 this is not used
    low = max(a, root) if slope > ZERO else a
    high = min(b, root) if slope < ZERO else b
    return low, low if (slope == ZERO) & (value < ZERO) else high


@device
def cross(xa, ya, qa, xb, yb, qb, a, b, i, last, keys, lines, v, low, high, veil, cuts, dark):
    """Darken a line, the piece after vertex v, between its places a and b, points (xa, ya) and (xb, yb) of one cell, by
    the bands in front of it there: those of the keys from i to before last."""
    n = last - i
    behind = nearness(min(qa, qb))
    bits = np.float32(WORD * dark.shape[0])
    begin = a * bits + HALF
    size = (b - a) * bits
    if all_dark(dark, np.int64(begin), np.int64(begin + size)):
        return
    for k in range(0, n, BATCH):
        if keys[i + k] >= behind:
            return
        count = min(n - k, BATCH)
        cut(lines, ROWS * i + k, n, count, xa, ya, qa, xb, yb, qb, cuts)
        covered = False
        for m in range(count):
            if cuts[m] < cuts[BATCH + m]:
                w = keys[i + k + m] & LOW
                if w < low or w > high:
                    since = np.int64(begin + cuts[m] * size)
                    covered |= darken(dark, since, np.int64(begin + cuts[BATCH + m] * size), veil, v, w)
        if covered and all_dark(dark, np.int64(begin), np.int64(begin + size)):
            return


@device
def cut(lines, at, n, count, xa, ya, qa, xb, yb, qb, cuts):
    """From where to where each of some bands covers a line, whose ends are 0 and 1: the ends' rows in `cuts`."""
    for k in range(count):
        here = np.uint64(at + k)
        x = lines[here + np.uint64(ASIDE_X * n)]
        y = lines[here + np.uint64(ASIDE_Y * n)]
        c = lines[here + np.uint64(ASIDE * n)]
        sa = c + x * xa + y * ya
        sb = c + x * xb + y * yb
        x = lines[here + np.uint64(ALONG_X * n)]
        y = lines[here + np.uint64(ALONG_Y * n)]
        c = lines[here + np.uint64(ALONG * n)]
        ua = c + x * xa + y * ya
        ub = c + x * xb + y * yb
        half = lines[here + np.uint64(WIDTH * n)]
        widens = lines[here + np.uint64(WIDENS * n)]
        q = lines[here + np.uint64(DEPTH * n)]
        grows = lines[here + np.uint64(GROWS * n)]
        half += ua * widens
        widens *= ub - ua
        low, high = between(ZERO, ONE, half - sa, widens + sa - sb)
        low, high = between(low, high, half + sa, widens + sb - sa)
        low, high = between(low, high, ua, ub - ua)
        low, high = between(low, high, ONE - ua, ua - ub)
        da = q + ua * grows - qa
        low, high = between(low, high, da, q + ub * grows - qb - da)
        cuts[k] = low
        cuts[BATCH + k] = high
