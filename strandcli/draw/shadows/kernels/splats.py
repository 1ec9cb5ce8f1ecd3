"""Splats of strands into the layers of an opacity map, a batch at a time.

A segment is cut at the borders of rows of texels where it is steep, else of columns. Each piece has the area that the
segment covers there, and adds it in its middle: to the two texels beside each other in its row, or above each other in
its column, by how near their centres are. So along a strand nothing wavers, wherever its segments begin.

Where a piece adds follows from two tables, of the depths of cells and of their rows, and from a division. One after the
other, the processor waits for each of them. Here a batch is collected, vectors find where all of its splats add and how
much, and a last loop adds, in the order in which they were collected.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, function
from ....simd import (
    bits_of_places,
    floor,
    gather4,
    half_width_pointer,
    lane_count,
    load,
    load_quadruples,
    pointer,
    prefetch,
    sqrt,
    store,
    where,
)
from ...common.kernels.numbers import HALF, ONE, STEPS, TWO, ZERO
from .map_parts import TINY
from .opacity import HEAD, TEXELS

FINEST = np.float32(64.0)
"""Most pieces that a texel is cut into where a segment leads away from the light."""
PER_TEXEL = np.float32(0.5)
"""Pieces for each texel of depth: where a segment leads away from the light by more than two in a texel's width."""
SEGMENTS = 16
"""Segments that are looked at together."""
RUN = 64
"""Segments of a run from which on they are drawn, and most vertices that come into it at once: whole vectors."""
BATCH = 256
"""Pieces of a batch: whole vectors."""

# Rows of numbers. First what is stored of segments: least and greatest place along the longer axis, texels, and that of
# the first vertex; there, place along the other axis, texels, and depth, metres; how much these change a texel; area a
# texel, texels; number of the first piece, how many there are, and how long each is, texels; 1 where it is steep.
LOW, HIGH, NEAR, ACROSS, DEPTH, STEP, RISE, AREA, BEGIN, PIECES, LENGTH, STEEP = (k * SEGMENTS for k in range(12))
VERTICES = 12 * SEGMENTS
"""The vertices of a run, as in `PartsInMap.vertices`."""
OUT = VERTICES + 4 * (2 * RUN + SEGMENTS)
"""Where the rows of a batch begin."""


@device
def append(work, filled, vertices, begin, count):
    """Bring up to `RUN` vertices from number `begin` on into a run that holds some; return how many it holds then."""
    rows, points = pointer(work), pointer(vertices)
    for at in range(0, 4 * count, lane_count(rows)):
        store(rows, VERTICES + 4 * filled + at, load(points, 4 * begin + at))
    return filled + count


@device
def find_segments(work, begin, count, window, view):
    """Write the rows of up to `SEGMENTS` segments of a run, which has so many, from number `begin` on; return how many.

    Texels cut segments; those that lead away from the light are cut into more pieces."""
    rows = pointer(work)
    top, bottom, size = np.float32(window.top), np.float32(window.bottom), np.float32(window.width)
    lane = load(pointer(STEPS), 0)
    none = ZERO * lane
    for k in range(0, SEGMENTS, lane_count(rows)):
        at = VERTICES + 4 * (begin + k)
        x0, y0, d0, _ = load_quadruples(rows, at)
        x1, y1, d1, wide = load_quadruples(rows, at + 4)
        dx, dy, rise = x1 - x0, y1 - y0, d1 - d0
        steep = abs(dy) >= abs(dx)
        near, far = where(steep, y0, x0), where(steep, y1, x1)
        low, high = min(near, far), max(near, far)
        length = high - low
        # flat segments add to the rows of cells next to theirs, and a light may be so near that a segment is longer
        # than its map
        there = (wide >= ZERO) & (lane < np.float32(count - begin - k))
        there = there & (length >= TINY) & (length <= size * np.float32(4.0))
        there = there & (max(y0, y1) >= top - ONE) & (min(y0, y1) <= bottom + ONE)
        away = abs(rise) * (PER_TEXEL * view.focal)
        if not view.far > ZERO:
            away *= HALF * (ONE / d0 + ONE / d1)
        parts = where(away > length, floor(min(away / length, FINEST)) + ONE, ONE + none)
        first = max(floor(parts * low), parts * where(steep, top + none, none))
        end = min(floor(parts * high) + ONE, parts * where(steep, bottom + none, size + none))
        slope = ONE / (far - near)
        store(rows, LOW + k, low)
        store(rows, HIGH + k, high)
        store(rows, NEAR + k, near)
        store(rows, ACROSS + k, where(steep, x0, y0))
        store(rows, DEPTH + k, d0)
        store(rows, STEP + k, where(steep, dx, dy) * slope)
        store(rows, RISE + k, rise * slope)
        store(rows, AREA + k, wide * sqrt(dx * dx + dy * dy) / length)
        store(rows, BEGIN + k, first)
        store(rows, PIECES + k, where(there, max(end - first, ZERO), none))
        store(rows, LENGTH + k, ONE / parts)
        store(rows, STEEP + k, where(steep, ONE + none, none))
    return min(count - begin, SEGMENTS)


OUTSIDE = np.float32(-10.0)
"""Place of a splat that adds nothing."""
HEAD_NUMBERS = 4
"""Numbers of a cell in `OpacityMap.heads`."""
PAIR = 2
"""Texels that a splat adds to."""

# Rows of a batch, one number a splat: place, texels, of which one is whole; depth, metres; area, texels². Then two rows
# each, one a texel: what is added, and int32 where.
U, V, DEEP, SIZE = (OUT + row * BATCH for row in range(4))
ADDED, AT = (OUT + row * BATCH for row in (4, 6))
ROOM = OUT + 8 * BATCH
"""Numbers of a batch with what is stored of segments."""


class OpacityMap(NamedTuple):
    """One map under construction."""

    heads: NDArray[np.float32]
    """(cells, 4) `opacity.START` and `opacity.SCALE`, 0 in empty cells, and the number of the cell's row, 0 in these;
    from `opacity_maps.divide`."""
    over: Any
    """float32: 1 / h, 1/m."""
    layers: int
    stacks: NDArray[np.float32] | None
    """(`opacity.numbers_of`,) the map itself, None before it is divided."""


@device
def collect(work, n, segments, s, past):
    """Add splats to a batch of n until it is full; return how many it holds then, and where to go on: the segment, and
    how many of its pieces are past. It calls nothing, so what a segment's pieces share stays in registers.

    work: rows above; s, past: where to begin."""
    rows = half_width_pointer(work)  # a segment has few pieces
    lanes = lane_count(rows)
    numbers = load(half_width_pointer(STEPS), 0)
    while s < segments:
        pieces = np.int64(work[PIECES + s])
        low, high, near, length = work[LOW + s], work[HIGH + s], work[NEAR + s], work[LENGTH + s]
        across, step, depth, rise = (
            work[ACROSS + s] - HALF,
            work[STEP + s],
            work[DEPTH + s],
            work[RISE + s],
        )
        along, beside = (V, U) if work[STEEP + s] > ZERO else (U, V)
        while past < pieces:
            if n > BATCH - lanes:
                return n, s, past
            piece = numbers + (work[BEGIN + s] + np.float32(past))
            begin, end = max(length * piece, low), min(length * (piece + ONE), high)
            t = HALF * (begin + end) - near
            store(rows, along + n, floor(length * (piece + HALF)))
            store(rows, beside + n, across + t * step)
            store(rows, DEEP + n, depth + t * rise)
            store(rows, SIZE + n, work[AREA + s] * max(end - begin, ZERO))  # it may end before its first texel
            n += min(pieces - past, lanes)
            past += lanes
        s += 1
        past = np.int64(0)
    return n, s, past


@function
def add(work, n, window, opacity_map):
    """Distribute the areas of the first n splats of a batch linearly to the two texels of each, in their layers; texels
    outside of the window are skipped."""
    rows = pointer(work)
    for k in range(n, -(-n // lane_count(rows)) * lane_count(rows)):
        work[U + k] = OUTSIDE
        work[V + k] = OUTSIDE
    for k in range(0, n, lane_count(rows)):
        find(rows, k, window, opacity_map)
    stacks, places = opacity_map.stacks, work.view(np.int32)
    numbers = pointer(stacks)
    for k in range(np.uint64(n)):
        prefetch(numbers, np.int64(places[np.uint64(AT) + k]))
        prefetch(numbers, np.int64(places[np.uint64(AT + BATCH) + k]))
    for k in range(np.uint64(n)):
        stacks[np.uint64(places[np.uint64(AT) + k])] += work[np.uint64(ADDED) + k]
        stacks[np.uint64(places[np.uint64(AT + BATCH) + k])] += work[np.uint64(ADDED + BATCH) + k]


@device
def find(rows, k, window, opacity_map):
    """Write where a vector of splats from number k on adds, and how much."""
    heads = pointer(opacity_map.heads)
    begin, stride = HEAD * (window.width >> 1) ** 2, TEXELS * (opacity_map.layers + 1)
    top, bottom, size = np.float32(window.top), np.float32(window.bottom), np.float32(window.width)
    u, v, d, area = load(rows, U + k), load(rows, V + k), load(rows, DEEP + k), load(rows, SIZE + k)
    left, up = floor(u), floor(v)
    u, v = u - left, v - up  # one of which is 0
    for texel in range(PAIR):
        row, column = up, left
        part = area * (ONE - (u + v))
        if texel == 1:
            row, column = where(v > ZERO, up + ONE, up), where(v > ZERO, left, left + ONE)
            part = area * (u + v)
        inside = (row >= top) & (row < bottom) & (column >= ZERO) & (column < size)
        cell_row, cell_column = floor(row * HALF), floor(column * HALF)
        cell = where(inside, cell_row * (size * HALF) + cell_column, ZERO)
        front, most, number, _ = gather4(heads, 0, cell, HEAD_NUMBERS, ZERO)
        far = max((d - front) * opacity_map.over, ZERO)
        ended = floor(most * (far / (far + ONE)))
        layer = min(ended, np.float32(opacity_map.layers - 1))
        own = TWO * (row - TWO * cell_row) + (column - TWO * cell_column)
        at = texel * BATCH + k
        number = where(inside, number, ZERO)
        place = np.float32(TEXELS) * (layer + ONE) + own
        store(rows, AT + at, bits_of_places(begin, number, stride, place))
        store(rows, ADDED + at, where(number > ZERO, part, ZERO))  # row 0 stays empty
