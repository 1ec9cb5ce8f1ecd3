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
    pointer,
    prefetch,
    store,
    where,
)
from ...common.kernels.numbers import HALF, ONE, STEPS, TWO, ZERO
from . import map_segments as seg
from .opacity import HEAD, TEXELS

OUTSIDE = np.float32(-10.0)
"""Place of a splat that adds nothing."""
HEAD_NUMBERS = 4
"""Numbers of a cell in `OpacityMap.heads`."""
PAIR = 2
"""Texels that a splat adds to."""

# Rows of a batch, one number a splat: place, texels, of which one is whole; depth, metres; area, texels². Then two rows
# each, one a texel: what is added, and int32 where.
U, V, DEEP, SIZE = (seg.OUT + row * seg.BATCH for row in range(4))
ADDED, AT = (seg.OUT + row * seg.BATCH for row in (4, 6))
ROOM = seg.OUT + 8 * seg.BATCH
"""Numbers of a batch with what is kept of segments."""


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
def collect(work, n, segments, window, opacity_map):
    """Add the splats of segments to a batch of n; return how many it holds then. A full batch is added to the map.

    work: rows of `map_segments`, of pieces of texels.
    """
    s = past = np.int64(0)
    while s < segments:
        n, s, past = collect_some(work, n, segments, s, past)
        if s < segments:
            add(work, n, window, opacity_map)
            n = np.int64(0)
    return n


@device
def collect_some(work, n, segments, s, past):
    """Add splats to a batch of n until it is full; return how many it holds then, and where to go on: the segment, and
    how many of its pieces are past. It calls nothing, so what a segment's pieces share stays in registers.

    s, past: where to begin; else as in `collect`."""
    rows = half_width_pointer(work)  # a segment has few pieces
    lanes = lane_count(rows)
    numbers = load(half_width_pointer(STEPS), 0)
    while s < segments:
        pieces = np.int64(work[seg.PIECES + s])
        low, high, near, length = work[seg.LOW + s], work[seg.HIGH + s], work[seg.NEAR + s], work[seg.LENGTH + s]
        across, step, depth, rise = (
            work[seg.ACROSS + s] - HALF,
            work[seg.STEP + s],
            work[seg.DEPTH + s],
            work[seg.RISE + s],
        )
        along, beside = (V, U) if work[seg.STEEP + s] > ZERO else (U, V)
        while past < pieces:
            if n > seg.BATCH - lanes:
                return n, s, past
            piece = numbers + (work[seg.BEGIN + s] + np.float32(past))
            begin, end = max(length * piece, low), min(length * (piece + ONE), high)
            t = HALF * (begin + end) - near
            store(rows, along + n, floor(length * (piece + HALF)))
            store(rows, beside + n, across + t * step)
            store(rows, DEEP + n, depth + t * rise)
            store(rows, SIZE + n, work[seg.AREA + s] * max(end - begin, ZERO))  # it may end before its first texel
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
        prefetch(numbers, np.int64(places[np.uint64(AT + seg.BATCH) + k]))
    for k in range(np.uint64(n)):
        stacks[np.uint64(places[np.uint64(AT) + k])] += work[np.uint64(ADDED) + k]
        stacks[np.uint64(places[np.uint64(AT + seg.BATCH) + k])] += work[np.uint64(ADDED + seg.BATCH) + k]


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
        at = texel * seg.BATCH + k
        number = where(inside, number, ZERO)
        place = np.float32(TEXELS) * (layer + ONE) + own
        store(rows, AT + at, bits_of_places(begin, number, stride, place))
        store(rows, ADDED + at, where(number > ZERO, part, ZERO))  # row 0 stays empty
