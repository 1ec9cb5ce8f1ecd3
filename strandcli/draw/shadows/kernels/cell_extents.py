"""Nearest and farthest depths of strands in the cells of an opacity map.

Each cell has those of the vertices in it and, as far as they are not much nearer or farther, in the eight cells about
it; and of places between vertices that are more than two cells apart, so that no cell that a segment passes is without.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined, parallel, prange
from ....simd import any_lane, floor, gather2, lane_count, load, load_quadruples, pointer, store, where
from ...common.kernels.numbers import HALF, INF, ONE, STEPS, ZERO
from .minmax import FARTHEST, NEAREST

START = np.float32(NEAREST)
APART = np.float32(4.0)
"""Texels between places of a segment, at most: two cells, so that a cell between them is next to one of theirs."""
LONGEST = np.float32(4.0)
"""Sides of a map that a segment may be long: a light may be so near that one is longer."""
WIDE = 3
"""Column of `PartsInMap.vertices`."""
LANES = 16
"""Lanes of a vector, at most."""
# Rows of a vector of places: the number of a cell, and the depth there twice, metres.
CELL, NEAR_DEPTH, FAR_DEPTH = (row * LANES for row in range(3))
ROOM = 3 * LANES
"""Numbers of these."""
PAIRS = 2
"""Numbers of a cell."""
NEXT = np.uint64(1)


@device
def widen(work, vertices, begin, count, longest, window, extents):
    """Widen the extents of cells by the vertices of a part, so many from number `begin` of `PartsInMap.vertices` on.

    longest: none of its segments is longer along an axis, texels."""
    points, heads = pointer(vertices), pointer(extents)
    lane = load(pointer(STEPS), 0)
    count -= np.int64(vertices[begin + count - 1, WIDE] < ZERO)  # the last vertex, if no segment ends there
    for k in range(0, count, lane_count(points)):
        x, y, d, _ = load_quadruples(points, 4 * (begin + k))
        widen_at(work, heads, extents, lane < np.float32(count - k), x, y, d, window)
        if longest > APART:
            widen_between(work, points, heads, extents, begin + k, count - k - 1, window)


@inlined
def widen_between(work, points, heads, extents, first, count, window):
    """Widen the extents of cells by places of so many segments, the first from vertex number `first` on."""
    size, lane = np.float32(window.width), load(pointer(STEPS), 0)
    x, y, d, _ = load_quadruples(points, 4 * first)
    x1, y1, d1, wide = load_quadruples(points, 4 * first + 4)
    dx, dy = x1 - x, y1 - y
    longer = max(abs(dx), abs(dy))
    there = (wide >= ZERO) & (lane < np.float32(count)) & (longer > APART) & (longer <= LONGEST * size)
    if any_lane(there):
        places = floor(longer * (ONE / APART)) + ONE
        per, place = ONE / places, ZERO * x + ONE
        there = there & (place < places)
        while any_lane(there):
            t = place * per
            widen_at(work, heads, extents, there, x + t * dx, y + t * dy, d + t * (d1 - d), window)
            place += ONE
            there = there & (place < places)


@inlined
def widen_at(work, heads, extents, there, x, y, depth, window):
    """Widen the extents of the cells of a vector of places within the window, texels, by depths, metres; there: where
    there is one; heads: `pointer` to extents."""
    rows, size = pointer(work), np.float32(window.width)
    # a segment may come to the map's outermost cells though its vertices are beyond them
    there = there & (max(abs(x - HALF * size), abs(y - HALF * size)) <= HALF * size + APART)
    x, y = min(max(x, ZERO), size - ONE), min(max(y, ZERO), size - ONE)
    there = there & (y >= np.float32(window.top)) & (y < np.float32(window.bottom))
    cell = where(there, floor(y * HALF) * np.float32(window.width >> 1) + floor(x * HALF), ZERO)
    begins, ends = gather2(heads, 0, cell, PAIRS, START)
    if any_lane(there & ((depth < begins) | (depth > ends))):
        store(rows, CELL, cell)
        store(rows, NEAR_DEPTH, where(there, depth, INF))
        store(rows, FAR_DEPTH, where(there, depth, -INF))
        for k in range(np.uint64(lane_count(rows))):
            at = np.uint64(work[np.uint64(CELL) + k])
            extents[at, NEAREST] = min(extents[at, NEAREST], work[np.uint64(NEAR_DEPTH) + k])
            extents[at, FARTHEST] = max(extents[at, FARTHEST], work[np.uint64(FAR_DEPTH) + k])


def room_of(side: int) -> tuple[int, int]:
    """Return the shape of the memory that `spread` needs."""
    return (side + 2) ** 2 + LANES, PAIRS


@parallel
def spread(extents, side, reach, found):
    """Widen the extents of cells by those of the eight about them, at both ends by at most `reach` metres; but empty
    ones have all that these have.

    extents (side², 2): nearest and farthest depth, metres, changed; side: cells along a side; found: memory, of the
    shape `room_of`.
    """
    across = side + 2
    numbers, padded = extents.reshape(-1), found.reshape(-1)
    for row in prange(across):
        begin = np.uint64(PAIRS * row * across)  # places cannot be negative: copies are vectors
        if row == 0 or row > side:
            fill_empty(padded, begin, np.uint64(across))
            continue
        fill_empty(padded, begin, NEXT)
        first = np.uint64(PAIRS * (row - 1) * side)
        for k in range(np.uint64(PAIRS * side)):
            padded[begin + np.uint64(PAIRS) + k] = numbers[first + k]
        fill_empty(padded, begin + np.uint64(PAIRS * (side + 1)), NEXT)
    for row in prange(side):
        work = np.empty(PAIRS * (side + LANES), np.float32)
        spread_row(found, np.int64(row) * across, across, side, reach, work)
        first = np.uint64(PAIRS * row * side)
        for k in range(np.uint64(PAIRS * side)):
            numbers[first + k] = work[k]


@device
def fill_empty(padded, begin, count):
    """Write the extents of so many empty cells, from a place in the numbers of cells on."""
    for k in range(count):
        padded[begin + np.uint64(PAIRS) * k] = INF
        padded[begin + np.uint64(PAIRS) * k + NEXT] = -INF


@device
def spread_row(found, first, across, side, reach, work):
    """Write the extents of a row of cells to work; first: the cell before them in the row above, in `found`."""
    rows, cells = pointer(work), pointer(found)
    for k in range(LANES):
        work[k] = np.float32(k % PAIRS)
    farthest = load(rows, 0) > ZERO
    for at in range(0, PAIRS * side, lane_count(rows)):
        begin = PAIRS * first + at
        least = greatest = own = load(cells, begin + PAIRS * (across + 1))
        for row in range(3):
            for column in range(3):
                one = load(cells, begin + PAIRS * (row * across + column))
                least, greatest = min(least, one), max(greatest, one)
        wider = where(farthest, min(greatest, own + reach), max(least, own - reach))
        store(rows, at, where(abs(own) < INF, wider, where(farthest, greatest, least)))
