"""Intervals of a line that bands of other strands occlude.

`darken_line` follows a line from cell to cell of the grid over the light's view (`grid`). The bands of a cell are
sorted nearest first, so the search ends at the first band behind the line. The inequalities run as one loop over bands,
which LLVM vectorises.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, DEPTH_RANGE, FOCAL, NEAR_PLANE, PERSPECTIVE
from ...view.kernels.project import to_view_number
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
    clamped_floor,
    columns,
    nearness,
)
from .interval_bits import WORD, all_dark, darken
from .self_shade import BEGIN, END

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
BATCH = 64
"""Bands that are tested against a line at once."""


class OccluderLists(NamedTuple):
    """Lists of all bands in the cells of a grid over each view of a light (see `grid`).

    A point light inside of the groom has six views, the sides of a cube.
    """

    views: NDArray[np.float32]
    """(M, `view_columns.SIZE`) packed, in cells."""
    sizes: NDArray[np.int64]
    """(M,) cells along a side of each view's grid."""
    cells: NDArray[np.int64]
    """(M,) index in `begin` of each view's first cell."""
    begin: NDArray[np.int64]
    """(C + 1,) index of each cell's first key."""
    keys: NDArray[np.int64]
    """(K,) keys, sorted in each cell."""
    rows: NDArray[np.float32]
    """(`grid.ROWS` K,) tables of the bands, as written by `grid.order`."""
    opacity: int
    """Opacity of strands, in 1 / `interval_bits.OPACITY_STEPS`."""
    bias: np.float32
    """Depth bias, metres."""


class OwnPieces(NamedTuple):
    """Parts of a segment that its own strand does not shade (see `self_shade`)."""

    low: int
    high: int
    """First vertices of the first and last segment of the strand that leave such a part."""
    root: int
    """First vertex of the strand."""
    parts: NDArray[np.float32]
    """(pieces, 2) interval t ∈ [0, 1] that each segment of the strand does not shade; undefined outside of low …
    high."""


class Span(NamedTuple):
    """The part of a line within one cell."""

    x0: np.float32
    y0: np.float32
    """Its beginning, in cells from the cell's corner."""
    q0: np.float32
    """Depth number at its beginning."""
    x1: np.float32
    y1: np.float32
    q1: np.float32
    begin: np.float32
    end: np.float32
    """Interval of the whole line, t ∈ [0, 1]."""


@device
def darken_line(ends, p, v, one, lists, own, cuts, dark):
    """Set the bits of `dark` where bands in view number `one` occlude a line.

    The line runs from row p of `ends` (n, 3), metres, to row p + 1, and represents the segment after vertex v; own:
    `OwnPieces`; cuts (2 BATCH,): scratch."""
    views, size = lists.views, lists.sizes[one]
    x0, y0, q0 = project(ends, p, views, one, lists.bias)
    x1, y1, q1 = project(ends, p + 1, views, one, lists.bias)
    if q0 <= ZERO or q1 <= ZERO:
        return
    dx = x1 - x0
    dy = y1 - y0
    dq = q1 - q0
    # the sides of a cube overlap by a margin; each handles only its own part
    edge = np.float32(1.5) if views.shape[0] > 1 else ZERO
    since, until = clip(ZERO, ONE, x0 - edge, dx)
    since, until = clip(since, until, np.float32(size) - edge - x0, -dx)
    since, until = clip(since, until, y0 - edge, dy)
    since, until = clip(since, until, np.float32(size) - edge - y0, -dy)
    if since >= until:
        return
    for row in range(clamped_floor(min(y0, y1), 0, size), clamped_floor(max(y0, y1) + ONE, 0, size)):
        left, right = columns(x0, y0, x1, y1, ZERO, row)
        above, under = clip(since, until, y0 - np.float32(row), dy)
        above, under = clip(above, under, np.float32(row + 1) - y0, -dy)
        for column in range(clamped_floor(left, 0, size), clamped_floor(right + ONE, 0, size)):
            a, b = clip(above, under, x0 - np.float32(column), dx)
            a, b = clip(a, b, np.float32(column + 1) - x0, -dx)
            cell = lists.cells[one] + row * size + column
            if a < b and lists.begin[cell] < lists.begin[cell + 1]:
                x = x0 - np.float32(column)
                y = y0 - np.float32(row)
                span = Span(x + a * dx, y + a * dy, q0 + a * dq, x + b * dx, y + b * dy, q0 + b * dq, a, b)
                darken_span(span, cell, v, lists, own, cuts, dark)


@inlined
def project(world, v, views, one, bias):
    """Return the position of vertex v in a view, in cells, and its biased depth number; 0 where it is not in front."""
    x, y, z = to_view_number(world[v, 0], world[v, 1], world[v, 2], views, one)
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
def clip(a, b, value, slope):
    """Return the part of the interval a <= t <= b where value + slope · t >= 0; if it is empty, the end is not greater
    than the beginning."""
    root = -value / slope  # not used where the slope is 0
    low = max(a, root) if slope > ZERO else a
    high = min(b, root) if slope < ZERO else b
    return low, low if (slope == ZERO) & (value < ZERO) else high


@device
def darken_span(span, cell, v, lists, own, cuts, dark):
    """Set the bits of `dark` where the bands of a cell occlude the `Span`; arguments as in `darken_line`."""
    keys = lists.keys
    i = lists.begin[cell]
    n = lists.begin[cell + 1] - i
    behind = nearness(min(span.q0, span.q1))
    bits = np.float32(WORD * dark.shape[0])
    begin = span.begin * bits + HALF
    size = (span.end - span.begin) * bits
    if all_dark(dark, np.int64(begin), np.int64(begin + size)):
        return
    for k in range(0, n, BATCH):
        count = nearer(keys, i + k, min(n - k, BATCH), behind)
        if count == 0:
            return
        cut(lists.rows, ROWS * i + k, n, count, span, cuts)
        covered = False
        for m in range(count):
            if cuts[m] < cuts[BATCH + m]:
                w = keys[i + k + m] & LOW
                since = np.int64(begin + cuts[m] * size)
                until = np.int64(begin + cuts[BATCH + m] * size)
                if w < own.low or w > own.high:
                    covered |= darken(dark, since, until, lists.opacity, v, w)
                elif w != v:
                    low = np.int64(own.parts[w - own.root, BEGIN] * bits + HALF)
                    high = np.int64(own.parts[w - own.root, END] * bits + HALF)
                    covered |= darken(dark, since, min(until, low), lists.opacity, v, w)
                    covered |= darken(dark, max(since, high), until, lists.opacity, v, w)
        if covered and all_dark(dark, np.int64(begin), np.int64(begin + size)):
            return


@device
def nearer(keys, at, count, behind):
    """Return how many of `count` sorted keys from number `at` on are less than `behind`."""
    low = np.int64(0)
    while low < count:
        middle = (low + count) >> 1
        if keys[at + middle] < behind:
            low = middle + 1
        else:
            count = middle
    return low


@device
def cut(lines, at, n, count, span, cuts):
    """Write the interval, t ∈ [0, 1], in which each of `count` bands occludes a span to the two rows of `cuts`.

    lines: `OccluderLists.rows`; at: index of the first band in the first row; n: bands of the cell."""
    xa, ya, qa, xb, yb, qb = span.x0, span.y0, span.q0, span.x1, span.y1, span.q1
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
        low, high = clip(ZERO, ONE, half - sa, widens + sa - sb)
        low, high = clip(low, high, half + sa, widens + sb - sa)
        low, high = clip(low, high, ua, ub - ua)
        low, high = clip(low, high, ONE - ua, ua - ub)
        da = q + ua * grows - qa
        low, high = clip(low, high, da, q + ub * grows - qb - da)
        cuts[k] = low
        cuts[BATCH + k] = high
