"""Vertices of parts of strands that an opacity map can tell apart (see `map_parts`).

Vertices less than `SHORT` behind the last are left out, but for the part's end; the segment over them covers as much as
theirs do, in its own place. So are most segments deep in shadow, of which the rest cover more (`deep_strands`).
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, inlined, parallel, prange
from ...common.kernels.numbers import HALF, INF, ONE, ZERO
from ...view.kernels.project import perspective_widening
from ...zbuffer.kernels.lines import Window
from . import cell_extents, map_parts
from .deep_strands import weight_of_vertex

STRANDS = 64
"""Strands a task."""


@parallel
def thin(strands, sketch, view, size, vertices, found, places, costs, extents):
    """Find the vertices and places of all parts, and widen the extents of a map's cells by them.

    strands: `StrandsInMap`; sketch: `Sketch`, by which most strands deep in shadow are left out; view: `MapView`; size:
    texels along a side; vertices: of `PartsInMap`, with room for all vertices and those that two parts share; found
    (R, 4) int32 out: the parts strand by strand, of which one that is not there has no vertices; places (R,) uint16
    out: on the Z-curve; costs (R,) out: of drawing, or without rows, where there is one band; R: S and `shared_before`
    all S strands; extents (cells, 2): as in `cell_extents`, no rows: none are widened. With extents, this runs on a
    single thread.
    """
    count = strands.first.shape[0] - 1
    window = Window(0, size, size)
    for task in prange((count + STRANDS - 1) // STRANDS):
        begin, end = np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, count)
        at = low = strands.first[begin] + map_parts.shared_before(strands.first, begin)
        work = np.empty(cell_extents.ROOM, np.float32)
        longest = ZERO
        for s in range(begin, end):
            row = s + map_parts.shared_before(strands.first, s)
            for number in range(s + 1 + map_parts.shared_before(strands.first, s + 1) - row):
                part = row + number
                found[part, map_parts.AT], found[part, map_parts.COUNT] = at, 0
                length = thin_part(
                    strands, s, number, part, sketch, view, size, (vertices, found, costs), strands.along
                )
                if found[part, map_parts.COUNT] > 0:
                    at += found[part, map_parts.COUNT]
                    longest = max(longest, length)
                    places[part] = map_parts.place_of(strands, s, number, size)
        if extents.shape[0] > 0 and at > low:  # of all parts at once: vectors wait for what was just written
            cell_extents.widen(work, vertices, low, at - low, longest, window, extents)


@device
def note_rows(low, high, cost, count, size, found, part, costs):
    """Write what is found of a part between two rows, texels, if the map has them."""
    # splats of flat segments add to the row next to theirs
    if low <= high and high >= -ONE and low <= np.float32(size):
        found[part, map_parts.COUNT] = count
        found[part, map_parts.TOP] = max(np.int64(low) - 1, 0)
        found[part, map_parts.BOTTOM] = min(np.int64(min(high, np.float32(size))) + 1, size - 1)
        if costs.shape[0] > 0:
            costs[part] = cost


@inlined
def thin_part(strands, s, number, part, sketch, view, size, out, along):
    """Write the vertices of a part of strand s, from its `AT` on, without those less than `SHORT` behind the last, what
    is found of it, and its cost. Return the length of its longest segment along an axis, texels.

    number: in its strand, part: among all; out: `vertices`, `found` and `costs` of `thin`; along: of the strands."""
    rows, found, costs = out
    width = map_parts.width_of(strands.width, strands.scale, s)
    screen, far, near, focal = strands.screen, view.far, view.near, view.focal
    a = strands.first[s]
    thin = width * strands.taper / np.float32(max(strands.first[s + 1] - a - 1, 1))
    middle = HALF * np.float32(size)
    begin, last = map_parts.part_range(strands.first, s, number)
    if begin >= last:
        return ZERO
    at = np.int64(found[part, map_parts.AT])
    longest = ZERO
    low, high, cost, n = INF, -INF, ZERO, at
    u = begin
    x0, y0, q0 = screen[u, 0], screen[u, 1], screen[u, 2]
    d0 = map_parts.depth_of(q0, near, far) if q0 > ZERO else ONE
    rows[n, map_parts.X], rows[n, map_parts.Y], rows[n, map_parts.DEPTH], rows[n, map_parts.WIDE] = x0, y0, d0, -ONE
    skipped = ZERO  # from the last vertex through those that are left out
    weight, ends = ONE, begin if sketch.chances.shape[0] > 0 else last  # of the group of segments up to `ends`
    for v in range(begin + 1, last + 1):
        if v > ends:
            ends = min(v + map_parts.GROUP - 1, last)
            weight = weight_of_vertex(sketch, screen, min(v + map_parts.GROUP // 2 - 1, last), view, sketch.chances[s])
        if weight == ZERO and v < ends:
            continue
        x1, y1, q1 = screen[v, 0], screen[v, 1], screen[v, 2]
        d1 = map_parts.depth_of(q1, near, far) if q1 > ZERO else ONE
        there = q0 > ZERO and q1 > ZERO and weight > ZERO
        scale = focal if far > ZERO else focal * HALF * (q0 + q1)
        if v < ends and there and max(max(abs(x1 - x0), abs(y1 - y0)), abs(d1 - d0) * scale) < map_parts.SHORT:
            skipped += distance(screen, v - 1, v)
            continue
        w = -ONE
        if there:
            if along is None:
                w = width - thin * (HALF * np.float32(u + v - a - a))
            else:
                w = width * (ONE - strands.taper * HALF * (along[u] + along[v]))
            wider = ONE
            if not far > ZERO:
                wider = perspective_widening(x0 - middle, y0 - middle, x1 - x0, y1 - y0, focal)
            w *= weight * scale * wider
            if skipped > ZERO:
                w *= (skipped + distance(screen, v - 1, v)) / max(distance(screen, u, v), map_parts.TINY)
            low, high = min(low, min(y0, y1)), max(high, max(y0, y1))
            length = max(abs(x1 - x0), abs(y1 - y0))
            longest = max(longest, length)
            cost += ONE + HALF * min(length, np.float32(size))
        if there or rows[n, map_parts.WIDE] >= ZERO:
            n += 1
        rows[n, map_parts.X], rows[n, map_parts.Y], rows[n, map_parts.DEPTH], rows[n, map_parts.WIDE] = x1, y1, d1, w
        u, x0, y0, q0, d0, skipped = v, x1, y1, q1, d1, ZERO
    last_ends = np.int32(rows[n, map_parts.WIDE] >= ZERO)  # at the last vertex a segment may not end
    note_rows(low, high, cost, n - at + last_ends, size, found, part, costs)
    return longest


@inlined
def distance(screen, u, v):
    """Return how far vertex v is from vertex u on the map, texels."""
    dx, dy = screen[v, 0] - screen[u, 0], screen[v, 1] - screen[u, 1]
    return np.float32(math.sqrt(dx * dx + dy * dy))
