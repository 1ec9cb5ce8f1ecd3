"""Which places of wide strands a picture shows, so that exact shadows are traced there alone."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, parallel, prange
from .column_light import COLUMNS, columns, places_of
from .masks import WHOLE
from .tiles import PIXELS, TILE_WIDTH, corner

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
TINY = np.float32(1e-12)
SHOWN = np.uint8(255)


@parallel
def expose(begin, kept, place, along, bits, table, screen, widths, slots, top, width, shown):
    """Mark what `lit.lit` will read of exact shadows.

    begin, kept, place, along, bits, top: of sorted fragments, as `resolve.resolve` leaves them, of a picture of
    this width; table: of `masks.sides`; bits may be (0,); screen (V, 3), widths (V,) samples; slots (V,)
    int32: number of a vertex' profile, or −1.
    shown (n, LINES, BYTES) uint8: `SHOWN` where a byte's places along a line of the piece after a vertex are seen. Two
    tiles may mark the same byte, both with the same number.
    """
    for one in prange(begin.shape[0]):
        tile = np.int64(one)
        f = begin[tile]
        if f < 0:
            continue
        y, x = corner(tile, width, top)
        shares = np.empty(COLUMNS, np.float32)
        for p in range(PIXELS):
            end = f + np.int64(kept[tile * PIXELS + p])
            while f < end:
                v = np.int64(place[f])
                if v < slots.shape[0] and slots[v] >= 0:  # beyond are the edges of solids
                    mark(
                        np.float32(x + p % TILE_WIDTH) + HALF, np.float32(y + p // TILE_WIDTH) + HALF, v, along[f],
                        WHOLE if bits.shape[0] == 0 else bits[f], table, screen, widths, np.int64(slots[v]), shares,
                        shown,
                    )  # fmt: skip
                f += 1


@device
def mark(x, y, v, t, bits, table, screen, widths, slot, shares, shown):
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
    begin, end, _ = columns(bits, table, dx, dy, off, radius, shares)
    for i in range(begin, end):
        if shares[i] > ZERO:
            for k in range(since // 8, (until - 1) // 8 + 1):
                shown[slot, i, k] = SHOWN
