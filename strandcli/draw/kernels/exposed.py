"""Which places of wide strands a picture shows, so that exact shadows are traced there alone."""

from __future__ import annotations

import math

import numpy as np

from ...jit import inner, parallel, prange
from .lit import columns_of, places_of
from .masks import EMPTY, WHOLE, behind, turned
from .tiles import PIXELS, TILE_HEIGHT, TILE_WIDTH

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
SHOWN = np.uint8(255)


@parallel
def expose(begin, kept, place, along, bits, table, screen, widths, slots, top, bottom, width, shown):
    """Mark what `lit.lit` will read of exact shadows.

    begin, kept, place, along, bits, top, bottom: of sorted fragments, as `resolve.resolve` leaves them, of a picture of
    this width; table: of `masks.sides`; bits and table may be None; screen (V, 3), widths (V,) samples; slots (V,)
    int32: number of a vertex' profile, or −1.
    shown (n, LINES, BYTES) uint8: `SHOWN` where a byte's places along a line of the piece after a vertex are seen. Two
    tiles may mark the same byte, both with the same number.
    """
    across = (width + TILE_WIDTH - 1) // TILE_WIDTH
    for one in prange(begin.shape[0]):
        tile = np.int64(one)
        i = begin[tile]
        if i < 0:
            continue
        y = top + tile // across * TILE_HEIGHT
        x = tile % across * TILE_WIDTH
        for row in range(y, min(y + TILE_HEIGHT, bottom)):
            for column in range(x, min(x + TILE_WIDTH, width)):
                n = np.int64(kept[tile * PIXELS + (row - y) * TILE_WIDTH + column - x])
                for f in range(i, i + n):
                    v = np.int64(place[f])
                    if v < slots.shape[0] and slots[v] >= 0:  # beyond are the edges of solids
                        mark(
                            np.float32(column) + HALF, np.float32(row) + HALF, v, along[f],
                            WHOLE if bits is None else bits[f], table, screen, widths, np.int64(slots[v]), shown,
                        )  # fmt: skip
                i += n


@inner
def mark(x, y, v, t, bits, table, screen, widths, slot, shown):
    """What the sample with the middle (x, y) shows of the piece after vertex v, at a place t of it."""
    dx = screen[v + 1, 0] - screen[v, 0]
    dy = screen[v + 1, 1] - screen[v, 1]
    size = math.sqrt(dx * dx + dy * dy)
    if size < TINY:
        return
    dx /= size
    dy /= size
    radius = HALF * (widths[v] + t * (widths[v + 1] - widths[v]))
    off = (y - screen[v, 1]) * dx - (x - screen[v, 0]) * dy
    since, until = places_of(t, HALF / size)
    low = since // 8
    high = (until - 1) // 8 + 1
    begin, end, edge, column = columns_of(off, radius, dx, dy)
    found = False
    if table is not None:  # noqa: SIM102  a branch of its own is left out where there are none
        if bits != WHOLE:
            turn = ONE if dx >= ZERO else -ONE
            way = turned(-dy * turn, dx * turn)
            lower = behind(table, way, turn, edge + np.float32(begin) * column)
            for i in range(begin, end):
                upper = behind(table, way, turn, edge + np.float32(i + 1) * column)
                if (bits & upper & ~lower) != EMPTY:
                    found = True
                    for k in range(low, high):
                        shown[slot, i, k] = SHOWN
                lower = upper
    if not found:
        for i in range(begin, end):
            for k in range(low, high):
                shown[slot, i, k] = SHOWN
