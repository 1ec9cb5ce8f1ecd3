"""Splats of strands into the layers of an opacity map, a batch at a time.

Where a splat adds follows from two tables, of the depths of cells and of their rows, and from a division. One splat
after the other, the processor waits for each of them. Here a batch is collected, vectors find where all of its splats
add and how much, and a last loop adds, in the order in which they were collected.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, function, inlined
from ....simd import floor, gather, lane_count, load, pointer, prefetch, store, where
from .opacity import FIVE, HEAD, SCALE, START, TEXELS

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
SHORT = np.float32(1.2)
"""Greatest distance between the samples of a segment, texels. Their footprints are two texels wide, and reading
averages over two again: along a strand the light varies by 1.5 % with 1.25 texels, by 6 % with 1.5."""
BATCH = 256
"""Splats of a batch: whole vectors."""
OUTSIDE = np.float32(-10.0)
"""Place of a splat that adds nothing."""

# Rows of a batch, one number a splat: place, texels; depth, metres; area, texels². Then four rows each, one a texel:
# the row of its cell in the map, 0 where nothing is added; the place in that row; what is added.
U, V, DEPTH, AREA = (row * BATCH for row in range(4))
ROW, PLACE, ADDED = (row * BATCH for row in (4, 8, 12))
ROWS = 16


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


@inlined
def count_spots(dx, dy, rise, scale, size, step):
    """Return how many places at most ``step`` texels apart a segment has: 0 where the light is so near that it is
    longer than four maps of ``size`` texels. dx, dy: its extent, texels; rise: in depth, metres; scale: texels a
    metre."""
    length = max(max(abs(dx), abs(dy)), abs(rise) * scale)
    if not length <= np.float32(4 * size):
        return np.int64(0)
    return np.int64(length * (ONE / step)) + 1


@device
def collect(batch, n, begin, end, scale, w, window, opacity_map):
    """Add the splats of a segment to a batch of n; return how many it holds then. A full batch is added to the map.

    Splats stand at most `SHORT` apart along the segment's greatest extent, depth included. batch: rows (ROWS * BATCH,)
    and places as in `add`; begin, end: x and y, texels, and depth, metres; scale: texels a metre; w: width, texels.
    """
    work = batch[0]
    x, y, d = begin
    dx, dy, rise = end[0] - x, end[1] - y, end[2] - d
    spots = count_spots(dx, dy, rise, scale, window.width, SHORT)
    per = ONE / np.float32(max(spots, 1))
    share = w * math.sqrt(dx * dx + dy * dy) * per
    dx *= per
    dy *= per
    rise *= per
    for spot in range(spots):
        if n == BATCH:
            add(work, batch[1], n, window, opacity_map)
            n = np.int64(0)
        t = np.float32(spot) + HALF
        work[U + n] = x + t * dx - HALF
        work[V + n] = y + t * dy - HALF
        work[DEPTH + n] = d + t * rise
        work[AREA + n] = share
        n += 1
    return n


@function
def add(work, places, n, window, opacity_map):
    """Distribute the areas of the first n splats of a batch bilinearly to the four texels around each, in their layers;
    texels outside of the window are skipped. places (TEXELS * BATCH,) int64: scratch, where in the map each one adds:
    all are fetched from memory before the first one is needed."""
    rows = pointer(work)
    for k in range(n, -(-n // lane_count(rows)) * lane_count(rows)):
        work[U + k] = OUTSIDE
        work[V + k] = OUTSIDE
    for k in range(0, n, lane_count(rows)):
        find(rows, k, window, opacity_map)
    stacks = opacity_map.stacks
    cells = np.int64((window.width >> 1) ** 2)
    stride = np.int64(HEAD + FIVE * (opacity_map.layers + 1))
    table = pointer(stacks)
    for at in range(0, TEXELS * BATCH, BATCH):
        for k in range(at, at + n):
            place = np.int64(work[ROW + k]) * stride + np.int64(work[PLACE + k])
            places[k] = cells + place
            prefetch(table, cells + place)
    for k in range(n):
        for at in range(k, k + TEXELS * BATCH, BATCH):
            if work[ROW + at] > ZERO:
                stacks[np.uint64(places[at])] += work[ADDED + at]


@device
def find(rows, k, window, opacity_map):
    """Write where a vector of splats from number k on adds, and how much."""
    heads, table = pointer(opacity_map.extents), pointer(opacity_map.stacks)
    top, bottom, size = np.float32(window.top), np.float32(window.bottom), np.float32(window.width)
    u, v, d, area = load(rows, U + k), load(rows, V + k), load(rows, DEPTH + k), load(rows, AREA + k)
    left, up = floor(u), floor(v)
    u, v = u - left, v - up
    for texel in range(TEXELS):
        row, column = up + np.float32(texel >> 1), left + np.float32(texel & 1)
        part = area * (v if texel > 1 else ONE - v)
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
        store(rows, ADDED + at, part * (u if texel & 1 else ONE - u))
