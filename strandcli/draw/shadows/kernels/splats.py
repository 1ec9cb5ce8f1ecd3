"""Splats of strands into the layers of an opacity map, a batch at a time.

A segment is cut at the borders of rows of texels where it is steep, else of columns. Each piece has the area that the
segment covers there, and adds it in its middle: to the two texels beside each other in its row, or above each other in
its column, by how near their centres are. So along a strand nothing wavers, wherever its segments begin.

Where a piece adds follows from two tables, of the depths of cells and of their rows, and from a division. One after the
other, the processor waits for each of them. Here a batch is collected, vectors find where all of its splats add and how
much, and a last loop adds, in the order in which they were collected.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, function
from ....simd import floor, gather, half_width_pointer, lane_count, load, pointer, store, where
from .opacity import FIVE, HEAD, SCALE, START

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
TINY = np.float32(1e-6)
"""Texels. A shorter segment adds nothing."""
FINEST = np.float32(64.0)
"""Most pieces that a texel is cut into where a segment leads away from the light."""
BATCH = 256
"""Splats of a batch: whole vectors."""
OUTSIDE = np.float32(-10.0)
"""Place of a splat that adds nothing."""
PAIR = 2
"""Texels that a splat adds to."""

# Rows of a batch, one number a splat: place, texels, of which one is whole; depth, metres; area, texels². Then two rows
# each, one a texel: the row of its cell in the map, 0 where nothing is added; the place in that row; what is added.
U, V, DEPTH, AREA = (row * BATCH for row in range(4))
ROW, PLACE, ADDED = (row * BATCH for row in (4, 6, 8))
COUNT = 10 * BATCH
"""The numbers from 0 on."""
ROWS = 11


class OpacityMap(NamedTuple):
    """One map under construction."""

    extents: NDArray[np.float32]
    """(cells, 2) before `divide`: `NEAREST` and `FARTHEST` depth, metres, (inf, −inf) in empty cells; after it:
    `opacity.START` and `opacity.SCALE`, 0 in empty cells."""
    over: Any
    """float32: 1 / h, 1/m."""
    layers: int
    stacks: NDArray[np.float32] | None
    """(`opacity.numbers_of`,) the map itself; None in the pass that finds the extents."""


@device
def start_batch(work):
    """Write the row `COUNT` of a batch."""
    for k in range(BATCH):
        work[COUNT + k] = np.float32(k)


@device
def pieces(begin, end, scale, window):
    """Return into how many pieces a segment cuts texels of its longer axis, its first piece within the window, and the
    end of its pieces: one piece a texel, or more where it leads farther away from the light than along the map.

    Arguments as in `collect`.
    """
    along, across = abs(end[1] - begin[1]), abs(end[0] - begin[0])
    steep = along >= across
    length = max(along, across)
    # the light may be so near that a segment is longer than its map
    if not (length >= TINY and length <= np.float32(4 * window.width)):
        return ONE, np.int64(0), np.int64(0)
    away = abs(end[2] - begin[2]) * scale
    parts = np.float32(np.int64(min(away / length, FINEST))) + ONE if away > length else ONE
    low = parts * (min(begin[1], end[1]) if steep else min(begin[0], end[0]))
    high = parts * (max(begin[1], end[1]) if steep else max(begin[0], end[0]))
    if not low < high:  # rounded, where the segment is the shortest that coordinates can tell
        return ONE, np.int64(0), np.int64(0)
    first, last = (window.top, window.bottom) if steep else (0, window.width)
    return parts, max(np.int64(low), first * np.int64(parts)), min(np.int64(high) + 1, last * np.int64(parts))


@device
def collect(work, n, begin, end, scale, w, window, opacity_map):
    """Add the splats of a segment to a batch of n; return how many it holds then. A full batch is added to the map.

    work (ROWS * BATCH,); begin, end: x and y, texels, and depth, metres; scale: texels a metre; w: width, texels.
    """
    parts, first, last = pieces(begin, end, scale, window)
    if first >= last:
        return n
    dx, dy, rise = end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]
    steep = abs(dy) >= abs(dx)
    near, far = (begin[1], end[1]) if steep else (begin[0], end[0])
    low, high = parts * min(near, far), parts * max(near, far)
    per = ONE / parts
    share = w * math.sqrt(dx * dx + dy * dy) / (high - low)
    slope = ONE / (far - near)
    across, step = (begin[0] - HALF, dx * slope) if steep else (begin[1] - HALF, dy * slope)
    along, beside = (V, U) if steep else (U, V)
    rows = half_width_pointer(work)  # a segment has few pieces
    lanes = lane_count(rows)
    for i in range(first, last, lanes):
        if n > BATCH - lanes:
            add(work, n, window, opacity_map)
            n = np.int64(0)
        piece = load(rows, COUNT) + np.float32(i)
        top, bottom = max(piece, low), min(piece + ONE, high)
        t = HALF * per * (top + bottom) - near
        store(rows, along + n, floor((piece + HALF) * per))
        store(rows, beside + n, across + t * step)
        store(rows, DEPTH + n, begin[2] + t * (rise * slope))
        store(rows, AREA + n, share * max(bottom - top, ZERO))  # a segment may end before the first texel
        n += min(last - i, lanes)
    return n


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
    stacks = opacity_map.stacks
    cells = np.int64((window.width >> 1) ** 2)
    stride = np.int64(HEAD + FIVE * (opacity_map.layers + 1))
    for k in range(n):
        for at in range(k, k + PAIR * BATCH, BATCH):
            row = np.int64(work[ROW + at])
            if row > 0:
                stacks[np.uint64(cells + row * stride + np.int64(work[PLACE + at]))] += work[ADDED + at]


@device
def find(rows, k, window, opacity_map):
    """Write where a vector of splats from number k on adds, and how much."""
    heads, table = pointer(opacity_map.extents), pointer(opacity_map.stacks)
    top, bottom, size = np.float32(window.top), np.float32(window.bottom), np.float32(window.width)
    u, v, d, area = load(rows, U + k), load(rows, V + k), load(rows, DEPTH + k), load(rows, AREA + k)
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
        far = max((d - gather(heads, 0, cell, 2, np.float32(START))) * opacity_map.over, ZERO)
        ended = floor(gather(heads, 0, cell, 2, np.float32(SCALE)) * (far / (far + ONE)))
        layer = min(ended, np.float32(opacity_map.layers - 1))
        own = TWO * (row - TWO * cell_row) + (column - TWO * cell_column)
        at = texel * BATCH + k
        store(rows, ROW + at, where(inside, gather(table, 0, cell, 1, ZERO), ZERO))
        store(rows, PLACE + at, np.float32(HEAD) + np.float32(FIVE) * (layer + ONE) + own)
        store(rows, ADDED + at, part)
