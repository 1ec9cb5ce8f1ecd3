"""Positions on wide strands that a picture shows, so that exact shadows are traced there alone."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, parallel, prange
from .column_light import COLUMNS, Crossing, column_shares, places_of
from .masks import ALL_POINTS
from .tiles import PIXELS, TILE_WIDTH, tile_at

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
TINY = np.float32(1e-12)
SHOWN = np.uint8(255)
"""All positions of a byte are shown."""


@parallel
def expose(fragments, table, profiles, out):
    """Mark the exact shadows that `column_light.column_light` will read.

    fragments: `tiles.Fragments`; table: from `masks.half_planes`; profiles: `width_profiles.Profiles`; out (n, LINES,
    BYTES) uint8: set to `SHOWN` where a sample shows positions of the byte, on a line of the segment after a vertex.
    Two tiles may write the same byte, but the same value.
    """
    for one in prange(fragments.begin.shape[0]):
        number = np.int64(one)
        f = fragments.begin[number]
        if f < 0:
            continue
        tile = tile_at(number, fragments)
        slots = profiles.slots
        vertex, along, points = fragments.vertex, fragments.along, fragments.points
        shares = np.empty(COLUMNS, np.float32)
        for p in range(PIXELS):
            end = f + np.int64(fragments.counts[number * PIXELS + p])
            while f < end:
                v = np.int64(vertex[f])
                if v < slots.shape[0] and slots[v] >= 0:  # greater numbers are edges of solids
                    mask = ALL_POINTS if points.shape[0] == 0 else points[f]
                    x = np.float32(tile.left + p % TILE_WIDTH) + HALF
                    y = np.float32(tile.top + p // TILE_WIDTH) + HALF
                    expose_segment(x, y, v, along[f], mask, table, profiles, shares, out)
                f += 1


@device
def expose_segment(x, y, v, t, points, table, profiles, shares, out):
    """Mark the positions that the sample with the centre (x, y) shows of the segment after vertex v, around t, 0 to 1;
    points: mask of the sample's points that show it; shares (COLUMNS,): scratch; other arguments as in `expose`."""
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
    begin, end, _ = column_shares(points, table, Crossing(dx, dy, off, radius), shares)
    slot = np.int64(profiles.slots[v])
    for i in range(begin, end):
        if shares[i] > ZERO:
            for k in range(since // 8, (until - 1) // 8 + 1):
                out[slot, i, k] = SHOWN
