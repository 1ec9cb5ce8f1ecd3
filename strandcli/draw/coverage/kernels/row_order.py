"""The rows of segments in a tile, in crowded tiles nearest first.

Where hundreds of strands lie behind each other, those in front are found first, and hide most of the others before
these have fragments (see `crowds`). Rows are ordered by the depth of their first vertex, in `SLICES` of depth: that
costs little, and no picture depends on the order. In fewer slices, the first fragments of a pixel are too far behind.
"""

from __future__ import annotations

import numpy as np

from ....jit import device
from .tile_binning import BLOCK
from .tiles import PIXELS

CROWDED = 384
"""Rows of a tile from which on they are ordered."""
SLICES = PIXELS - 1
SLICE_COUNT = np.float32(SLICES)
TINY = np.float32(1e-30)


@device
def list_rows(segments, tile, slots):
    """Write where the rows of a tile are in the pool to slots (room,) int32, as many as there is room for; return how
    many there are. segments: `tile_binning.TileSegments`."""
    n = np.int64(0)
    room = slots.shape[0]
    for one in range(segments.heads.shape[0]):
        block, stop = segments.heads[one, tile], segments.fills[one, tile]
        while stop > 0:
            final = block == (stop - 1) // BLOCK
            begin, end = block * BLOCK, stop if final else block * BLOCK + BLOCK
            for slot in range(begin, min(end, begin + max(room - n, 0))):
                slots[n + slot - begin] = slot
            n += end - begin
            if final:
                break
            block = segments.links[block]
    return n


@device
def order_rows(row_depths, slots, listed, depths, begin):
    """Write listed rows (n,) to slots (n,), nearest first; row_depths: of `TileSegments`; depths (n or more,) float32,
    begin (PIXELS,) int32: scratch."""
    n = slots.shape[0]
    low, high = np.float32(np.inf), np.float32(-np.inf)
    for i in range(n):
        depth = row_depths[listed[i]]
        depths[i] = depth
        low, high = min(low, depth), max(high, depth)
    per = SLICE_COUNT / max(high - low, TINY)
    begin[:] = 0
    for i in range(n):
        begin[slice_of(depths[i], high, per) + 1] += 1
    for k in range(SLICES):
        begin[k + 1] += begin[k]
    for i in range(n):
        k = slice_of(depths[i], high, per)
        slots[begin[k]] = listed[i]
        begin[k] += 1


@device
def slice_of(depth, high, per):
    """Return the slice of a depth number; high: the greatest; per: slices for each unit of depth numbers."""
    return min(np.int64((high - depth) * per), SLICES - 1)
