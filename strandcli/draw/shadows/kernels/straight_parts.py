"""Vertices of a part of a strand as a directional light sees them, a vector of them at a time.

`part_vertices` leaves out vertices that are less than `SHORT` behind the last, one after the other. Most parts have
none, for polylines come without vertices at which they hardly bend (`simplify`), and are written here as they are.
"""

from __future__ import annotations

import numpy as np

from ....constants import VECTOR
from ....jit import device, inlined
from ....simd import (
    any_lane,
    count_true,
    interleaved,
    load,
    load_deinterleaved,
    pointer,
    store,
    where,
)
from ...common.kernels.numbers import HALF, ONE, STEPS, ZERO
from .deep_strands import weight_of_vertex
from .map_parts import DEPTH, GROUP, SHORT, WIDE, X, Y

LANES = VECTOR // 4
MOST = 64
"""Segments of a part that is written here, at most: whole vectors."""
FEWEST = 5
"""At least: fewer are written sooner one by one."""
# Rows of numbers: 1 at all segments of a group but the last; what may not be written as it is.
INNER, TAIL = 0, LANES
ROOM = TAIL + 4 * LANES
"""Numbers of these."""
COLUMNS = 4
"""Of `PartsInMap.kept`."""


@device
def start(work):
    """Write the row `INNER`."""
    for k in range(LANES):
        work[INNER + k] = np.float32((k + 1) % GROUP > 0)


@inlined
def fits(begin, last, screen, view):
    """Return whether the vertices from number `begin` to `last` of the light's screen may be written here: vectors
    reach beyond the last one, but not beyond the array."""
    segments = last - begin
    return view.far > ZERO and FEWEST <= segments <= MOST and begin + segments + LANES < screen.shape[0]


@inlined
def write(work, strands, sketch, view, strand, kept, at, limit):
    """Write the vertices of a part to `PartsInMap.kept` from number `at` on. Return how many they are, 0 if none of its
    segments comes to the map's rows, or −1 if one is too short; and the length of its longest segment along an axis,
    texels, as a vector.

    work: rows above; strands: `StrandsInMap`; strand: its number, its first vertex, and first and last one of the part,
    its width at the root, metres, and by how much that is less a vertex, and rows of the map; limit: no number of
    `kept` from there on may change."""
    s, root, begin, last, width, thin, size = strand
    segments = last - begin
    rows, points, screen = pointer(work), pointer(strands.screen), strands.screen
    lane = load(pointer(STEPS), 0)
    kept[at, X], kept[at, Y], kept[at, WIDE] = screen[begin, 0], screen[begin, 1], -ONE
    kept[at, DEPTH] = depth_at(screen[begin, 2], view) if screen[begin, 2] > ZERO else ONE
    longest = ZERO * lane
    drawn = np.uint64(0)
    below = above = False
    for k in range(0, segments, LANES):
        x0, y0, q0 = load_deinterleaved(points, 3 * (begin + k))
        x1, y1, q1 = load_deinterleaved(points, 3 * (begin + k + 1))
        d0 = where(q0 > ZERO, depth_at(q0, view), ONE)
        d1 = where(q1 > ZERO, depth_at(q1, view), ONE)
        there = (lane < np.float32(segments - k)) & (min(q0, q1) > ZERO)
        length = max(abs(x1 - x0), abs(y1 - y0))
        may = there & (lane < np.float32(segments - k - 1))  # the vertices that `part_vertices` may leave out
        if sketch.chances.shape[0] > 0:
            may = may & (load(rows, INNER) > ZERO)
        if any_lane(may & (max(length, abs(d1 - d0) * view.focal) < SHORT)):
            return np.int64(-1), longest
        scale = ONE * view.focal + ZERO * lane
        if sketch.chances.shape[0] > 0:
            weight = weights_at(strands.screen, begin + k, last, view, sketch, sketch.chances[s], lane)
            there = there & (weight > ZERO)
            scale = weight * view.focal
        places = np.float32(2 * (begin + k - root) + 1) + (lane + lane)
        w = width_at(strands.along, begin + k, places, width, thin, strands.taper)
        w = where(there, w * scale, -ONE)
        longest = max(longest, where(there, length, ZERO))
        drawn += count_true(there)
        below |= any_lane(there & (max(y0, y1) >= -ONE))  # splats of flat segments add to the row next to theirs
        above |= any_lane(there & (min(y0, y1) <= np.float32(size)))
        store_vertices(work, kept, at + 1 + k, min(segments - k, LANES), limit, (x1, y1, w, d1))
    if not (below and above):
        return np.int64(0), longest
    return segments + 1 if drawn == np.uint64(segments) else close_up(kept, at, segments + 1), longest


@inlined
def store_vertices(work, kept, at, count, limit, columns):
    """Store a vector of vertices, x, y, width and depth, of which `count` are there, in `kept` from number `at` on."""
    x, y, w, d = columns
    rows, out, place = pointer(work), pointer(kept), COLUMNS * at
    x_d, x_d_next = interleaved(x, d)
    y_w, y_w_next = interleaved(y, w)
    first, second = interleaved(x_d, y_w)
    third, fourth = interleaved(x_d_next, y_w_next)
    if at + LANES <= limit:
        store(out, place, first)
        store(out, place + LANES, second)
        store(out, place + 2 * LANES, third)
        store(out, place + 3 * LANES, fourth)
    else:
        store(rows, TAIL, first)
        store(rows, TAIL + LANES, second)
        store(rows, TAIL + 2 * LANES, third)
        store(rows, TAIL + 3 * LANES, fourth)
        copy_tail(work, kept, at, count)


@inlined
def depth_at(q, view):
    """Return the depth, metres, of a depth number of a directional light's view."""
    return view.near + (ONE - q) * view.far


@inlined
def width_at(along, first, places, width, thin, taper):
    """Return the mean widths, metres, of a vector of segments, the first of which begins at vertex number `first`.

    along: of `StrandsInMap`; places: sums of the places of their ends, in vertices from the root; width, thin:
    metres at the root, and less a vertex."""
    if along is None:
        return width - thin * (HALF * places)
    points = pointer(along)
    return width * (ONE - taper * HALF * (load(points, first) + load(points, first + 1)))


@inlined
def weights_at(screen, begin, last, view, sketch, chance, lane):
    """Return the weights of a vector of segments, the first of which begins at vertex number `begin`, of four groups;
    last: vertex of the part; chance: of the strand."""
    first = weight_of_group(screen, begin, last, view, sketch, chance)
    second = weight_of_group(screen, begin + GROUP, last, view, sketch, chance)
    third = weight_of_group(screen, begin + 2 * GROUP, last, view, sketch, chance)
    fourth = weight_of_group(screen, begin + 3 * GROUP, last, view, sketch, chance)
    none = ZERO * lane
    low = where(lane < np.float32(GROUP), first + none, second)
    return where(lane < np.float32(2 * GROUP), low, where(lane < np.float32(3 * GROUP), third + none, fourth))


@inlined
def weight_of_group(screen, begin, last, view, sketch, chance):
    """Return the weight of the segments of a group, the first of which begins at vertex number `begin`."""
    if begin >= last:
        return ONE
    return weight_of_vertex(sketch, screen, min(begin + GROUP // 2, last), view, chance)


@device
def copy_tail(work, kept, at, count):
    """Copy so many vertices from the row `TAIL` to number `at` of `PartsInMap.kept` and after it."""
    for k in range(count):
        for column in range(COLUMNS):
            kept[at + k, column] = work[TAIL + COLUMNS * k + column]


@device
def close_up(kept, at, count):
    """Leave out, of so many vertices from number `at` on, those at which no segment begins or ends; return how many
    are left."""
    n = at
    for k in range(at, at + count):
        ends = kept[k, WIDE] >= ZERO
        begins = k + 1 < at + count and kept[k + 1, WIDE] >= ZERO
        for column in range(COLUMNS):
            kept[n, column] = kept[k, column]
        n += np.int64(ends or begins)
    return n - at
