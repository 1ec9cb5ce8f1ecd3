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

from ....jit import device, function
from ....simd import floor, gather, lane_count, load, pointer, store, where
from .opacity import FIVE, HEAD, SCALE, START, TEXELS

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
SHORT = np.float32(1.5)
"""Longest segment, in texels, that is splatted as one sample, whose footprint is two texels wide."""
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


@device
def collect(work, n, begin, end, scale, w, window, opacity_map):
    """Add the splats of a segment to a batch of n; return how many it holds then. A full batch is added to the map.

    One splat for each texel of the segment's greatest extent, depth included, or one at its centre if that is at most
    `SHORT`. work (ROWS * BATCH,); begin, end: x and y, texels, and depth, metres; scale: texels a metre; w: width,
    texels.
    """
    x, y, d = begin
    dx, dy, rise = end[0] - x, end[1] - y, end[2] - d
    length = max(max(abs(dx), abs(dy)), abs(rise) * scale)
    if not length <= np.float32(4 * window.width):  # the light is so near that a segment is longer than its map
        return n
    spots = np.int64(length) + 1 if length > SHORT else np.int64(1)
    per = ONE / np.float32(spots)
    share = w * math.sqrt(dx * dx + dy * dy) * per
    dx *= per
    dy *= per
    rise *= per
    for spot in range(spots):
        if n == BATCH:
            add(work, n, window, opacity_map)
            n = np.int64(0)
        t = np.float32(spot) + HALF
        work[U + n] = x + t * dx - HALF
        work[V + n] = y + t * dy - HALF
        work[DEPTH + n] = d + t * rise
        work[AREA + n] = share
        n += 1
    return n


@function
def add(work, n, window, opacity_map):
    """Distribute the areas of the first n splats of a batch bilinearly to the four texels around each, in their layers;
    texels outside of the window are skipped."""
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
        for at in range(k, k + TEXELS * BATCH, BATCH):
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
