"""Which places of wide strands a picture shows, so that exact shadows are traced there alone."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, parallel, prange
from .column_light import COLUMNS, Crossing, columns, places_of
from .masks import WHOLE
from .tiles import PIXELS, TILE_WIDTH, tile_at

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
TINY = np.float32(1e-12)
SHOWN = np.uint8(255)


@parallel
def expose(fragments, table, profiles, out):
    """Mark what `column_light.column_light` will read of exact shadows.

    fragments: `tiles.Fragments`; table: of `masks.sides`; profiles: `width_profiles.Profiles`.
    out (n, LINES, BYTES) uint8: `SHOWN` where a byte's places along a line of the piece after a vertex are seen. Two
    tiles may mark the same byte, both with the same number.
    """
    for one in prange(fragments.begin.shape[0]):
        number = np.int64(one)
        f = fragments.begin[number]
        if f < 0:
            continue
        tile = tile_at(number, fragments)
        slots = profiles.slots
        place, along, seen = fragments.place, fragments.along, fragments.seen
        shares = np.empty(COLUMNS, np.float32)
        for p in range(PIXELS):
            end = f + np.int64(fragments.kept[number * PIXELS + p])
            while f < end:
                v = np.int64(place[f])
                if v < slots.shape[0] and slots[v] >= 0:  # beyond are the edges of solids
                    points = WHOLE if seen.shape[0] == 0 else seen[f]
                    x = np.float32(tile.left + p % TILE_WIDTH) + HALF
                    y = np.float32(tile.top + p // TILE_WIDTH) + HALF
                    mark(x, y, v, along[f], points, table, profiles, shares, out)
                f += 1


@device
def mark(x, y, v, t, points, table, profiles, shares, out):
    """Mark what these points of the sample with the middle (x, y) show of the piece after vertex v, at a place t of
    it."""
    screen = profiles.screen
    widths = profiles.widths
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
    begin, end, _ = columns(points, table, Crossing(dx, dy, off, radius), shares)
    slot = np.int64(profiles.slots[v])
    for i in range(begin, end):
        if shares[i] > ZERO:
            for k in range(since // 8, (until - 1) // 8 + 1):
                out[slot, i, k] = SHOWN
