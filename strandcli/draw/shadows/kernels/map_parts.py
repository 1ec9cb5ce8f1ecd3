"""Parts of strands as a light sees them: the vertices that its map can tell apart, and an order of the parts.

Both passes over an opacity map draw the same segments. What they need of these is found once: vertices less than
`SHORT` behind the last are left out, but for the part's end; the segment over them covers as much as theirs do, in its
own place. So are most segments deep in shadow, of which the others cover more (`deep_strands`).

Parts near each other on the map follow each other, along a Z-curve. They add to the same cells, which then are in the
processor's cache. Sums are rounded otherwise in another order, so it is that of places on the map alone. Each thread
draws a band of rows, with about as much work as the others have.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined, parallel, prange
from ...view.kernels.project import perspective_widening
from ...zbuffer.kernels.lines import Window
from . import cell_extents
from .deep_strands import weight_at

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
INF = np.float32(np.inf)
TINY = np.float32(1e-6)
"""Texels."""
PARTS, PART = 4, 48
"""Most parts of a strand that are drawn apart, and segments of all but the last. A part costs as much to draw as some
six segments."""
REST = 8
"""Segments at the end of a strand, up to so many, that belong to the part before them."""
GROUP = 4
"""Segments that are left out, or not, together."""
SHORT = np.float32(0.5)
"""Texels."""
BITS = 8
"""Of a place, of each coordinate: 256 × 256 tiles, of two to eight texels."""
STRANDS = 64
"""Strands a task."""
AT, COUNT, TOP, BOTTOM = range(4)
"""Columns of a part: its first row in `PartsInMap.kept`, the number of its vertices, and the first and the last row of
texels that it comes to."""
X, Y, DEPTH, WIDE = range(4)
"""Columns of `PartsInMap.kept`."""


class StrandsInMap(NamedTuple):
    """Strands projected into a light's view."""

    first: NDArray[np.int64]
    """(S + 1,) first vertex of each strand, and the number of vertices."""
    screen: NDArray[np.float32]
    """(V, 3) x and y in texels, and the depth number of `project.points`."""
    width: Any
    """float32: metres at the root; the width at the tip is smaller by the share `taper`."""
    taper: Any
    """float32, 0 to 1."""
    scale: NDArray[np.float32] | None
    """(S,) factor of each strand's width; None stands for 1."""
    along: NDArray[np.float32] | None = None
    """(V,) how far along its strand each vertex stands, 0 to 1; None: evenly."""


class MapView(NamedTuple):
    """Constants of a light's view that convert depth numbers to metres and metres to texels."""

    far: Any
    """float32: depth range of an orthographic view, metres, or 0 for a perspective one."""
    near: Any
    """float32: nearest depth of an orthographic view, metres."""
    focal: Any
    """float32: texels a metre; for a perspective view at a depth of one metre."""


class PartsInMap(NamedTuple):
    """What is drawn into one map."""

    kept: NDArray[np.float32]
    """(K, 4) vertices, part by part: x and y, texels; depth, metres; and the mean width, texels, of the segment that
    ends there, less than 0 if none does."""
    order: NDArray[np.int32]
    """(P, 4) the parts, columns above."""
    borders: NDArray[np.int64]
    """(threads + 1,) even rows of texels between the bands."""


def spread_bits() -> NDArray[np.int64]:
    """Return (2^`BITS`,) for each number its bits, each behind one that is 0."""
    numbers = np.arange(1 << BITS)
    return np.asarray(sum((numbers >> bit & 1) << 2 * bit for bit in range(BITS)))


SPREAD = spread_bits()


@parallel
def thin(strands, sketch, view, size, kept, found, places, costs, extents):
    """Find the vertices and places of all parts, and widen the extents of a map's cells by them.

    strands: `StrandsInMap`; sketch: `Sketch`, by which most strands deep in shadow are left out; view: `MapView`; size:
    texels along a side; kept: of `PartsInMap`, with room for all vertices and those that two parts share; found
    (R, 4) int32 out: the parts strand by strand, of which one that is not there has no vertices; places (R,) uint16
    out: on the Z-curve; costs (R,) out: of drawing; R: S and `shared_before` all S strands; extents
    (cells, 2): as in `cell_extents`, no rows: none are widened. With extents, this runs on a single thread.
    """
    count = strands.first.shape[0] - 1
    window = Window(0, size, size)
    for task in prange((count + STRANDS - 1) // STRANDS):
        begin, end = np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, count)
        at = low = strands.first[begin] + shared_before(strands.first, begin)
        longest = ZERO
        for s in range(begin, end):
            row = s + shared_before(strands.first, s)
            for number in range(s + 1 + shared_before(strands.first, s + 1) - row):
                part = row + number
                found[part, AT] = at
                length = thin_part(strands, s, number, sketch, view, size, kept, found, costs, strands.along)
                if found[part, COUNT] > 0:
                    at += found[part, COUNT]
                    longest = max(longest, length)
                    places[part] = place_of(strands, s, number, size)
        if extents.shape[0] > 0 and at > low:  # of all parts at once: vectors wait for what was just written
            work = np.empty(cell_extents.ROOM, np.float32)
            cell_extents.start(work)
            cell_extents.widen(work, kept, low, at - low, longest, window, extents)


@device
def shared_before(first, s):
    """Return how many vertices two parts share at most of the strands before strand s: `PARTS` - 1 of a strand, one of
    each `PART` vertices. first: of `StrandsInMap`."""
    return min(s * (PARTS - 1), first[s] // PART)


@device
def part_range(first, s, number):
    """Return the first vertex of a part of strand s, and the last, which is the first of the next part; the same one
    twice for a part that is not there. first: of `StrandsInMap`."""
    last = first[s + 1] - 1
    begin = first[s] + number * PART
    if number >= PARTS or (number > 0 and begin + REST >= last):
        return last, last
    return begin, last if number == PARTS - 1 or begin + PART + REST >= last else begin + PART


@device
def place_of(strands, s, number, size):
    """Return the place on the Z-curve of the middle vertex of a part of strand s."""
    begin, _ = part_range(strands.first, s, number)
    middle = min(begin + PART // 2, (begin + strands.first[s + 1] - 1) // 2)
    tiles = np.float32(1 << BITS) / np.float32(size)
    x = np.int64(min(max(strands.screen[middle, 0] * tiles, ZERO), np.float32((1 << BITS) - 1)))
    y = np.int64(min(max(strands.screen[middle, 1] * tiles, ZERO), np.float32((1 << BITS) - 1)))
    return SPREAD[x] | SPREAD[y] << 1


@device
def depth_of(q, near, far):
    """Return the depth, metres, of a depth number; near, far: of `MapView`."""
    return near + (ONE - q) * far if far > ZERO else ONE / q


@inlined
def too_short(begin, end, scale):
    """Return whether a segment is less than `SHORT` along all axes. begin, end: x and y, texels, and depth, metres;
    scale: texels a metre."""
    dx, dy, rise = end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]
    return max(max(abs(dx), abs(dy)), abs(rise) * scale) < SHORT


@inlined
def distance(screen, u, v):
    """Return how far vertex v is from vertex u on the map, texels."""
    dx, dy = screen[v, 0] - screen[u, 0], screen[v, 1] - screen[u, 1]
    return np.float32(math.sqrt(dx * dx + dy * dy))


@inlined
def widening(x, y, dx, dy, view):
    """Return by how much perspective widens a segment away from the axis; x, y: from the middle, texels."""
    return ONE if view.far > ZERO else perspective_widening(x, y, dx, dy, view.focal)


@inlined
def width_of(width, scale, s):
    """Return the width of strand s at its root, metres."""
    return width if scale is None else width * scale[s]


@device
def weight_of_vertex(sketch, screen, v, view, s):
    """Return the weight of strand s at a vertex; 1 where that is behind a light."""
    if not screen[v, 2] > ZERO:
        return ONE
    depth = depth_of(screen[v, 2], view.near, view.far)
    return weight_at(sketch, screen[v, 0], screen[v, 1], depth, sketch.chances[s])


@inlined
def thin_part(strands, s, number, sketch, view, size, kept, found, costs, along):
    """Write the vertices of a part of strand s, from its `AT` on, what is found of it, and its cost; along: of the
    strands. Return the length of its longest segment along an axis, texels."""
    width = width_of(strands.width, strands.scale, s)
    screen, far, near, focal = strands.screen, view.far, view.near, view.focal
    a = strands.first[s]
    thin = width * strands.taper / np.float32(max(strands.first[s + 1] - a - 1, 1))
    middle = HALF * np.float32(size)
    begin, last = part_range(strands.first, s, number)
    part = s + shared_before(strands.first, s) + number
    at = np.int64(found[part, AT])
    found[part, COUNT] = 0
    longest = ZERO
    if begin >= last:
        return longest
    low, high, cost, n = INF, -INF, ZERO, at
    u = begin
    x0, y0, q0 = screen[u, 0], screen[u, 1], screen[u, 2]
    d0 = depth_of(q0, near, far) if q0 > ZERO else ONE
    kept[n, X], kept[n, Y], kept[n, DEPTH], kept[n, WIDE] = x0, y0, d0, -ONE
    way = ZERO  # from the last vertex by way of those that are left out
    weight, ends = ONE, begin if sketch.chances.shape[0] > 0 else last  # of the group of segments up to `ends`
    for v in range(begin + 1, last + 1):
        if v > ends:
            ends = min(v + GROUP - 1, last)
            weight = weight_of_vertex(sketch, screen, min(v + GROUP // 2 - 1, last), view, s)
        if weight == ZERO and v < ends:
            continue
        x1, y1, q1 = screen[v, 0], screen[v, 1], screen[v, 2]
        d1 = depth_of(q1, near, far) if q1 > ZERO else ONE
        there = q0 > ZERO and q1 > ZERO and weight > ZERO
        scale = focal if far > ZERO else focal * HALF * (q0 + q1)
        if v < ends and there and too_short((x0, y0, d0), (x1, y1, d1), scale):
            way += distance(screen, v - 1, v)
            continue
        w = -ONE
        if there:
            if along is None:
                w = width - thin * (HALF * np.float32(u + v - a - a))
            else:
                w = width * (ONE - strands.taper * HALF * (along[u] + along[v]))
            w *= weight * scale * widening(x0 - middle, y0 - middle, x1 - x0, y1 - y0, view)
            if way > ZERO:
                w *= (way + distance(screen, v - 1, v)) / max(distance(screen, u, v), TINY)
            low, high = min(low, min(y0, y1)), max(high, max(y0, y1))
            length = max(abs(x1 - x0), abs(y1 - y0))
            longest = max(longest, length)
            cost += ONE + HALF * min(length, np.float32(size))
        if there or kept[n, WIDE] >= ZERO:
            n += 1
        kept[n, X], kept[n, Y], kept[n, DEPTH], kept[n, WIDE] = x1, y1, d1, w
        u, x0, y0, q0, d0, way = v, x1, y1, q1, d1, ZERO
    # splats of flat segments add to the row next to theirs
    if low <= high and high >= -ONE and low <= np.float32(size):
        found[part, COUNT] = n - at + np.int32(kept[n, WIDE] >= ZERO)  # at the last vertex a segment may not end
        found[part, TOP] = max(np.int64(low) - 1, 0)
        found[part, BOTTOM] = min(np.int64(min(high, np.float32(size))) + 1, size - 1)
        costs[part] = cost
    return longest
