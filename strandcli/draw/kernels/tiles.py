"""Tiles of a picture, and the fragments that lie in each: chains of blocks out of one pool.

A tile is `TILE_HEIGHT` rows of `TILE_WIDTH` pixels, few enough for its lists to stay in a core's own cache, and its
fragments are appended as they are found. Each worker has its share of the pool and a chain of its own in every tile, so
nobody waits for anybody.

A fragment is two 64-bit numbers. Its key is what it is sorted by: the depth number, complemented so that nearer is
smaller, above the index of the piece's first vertex. A piece touches a pixel once, so that keys differ within a pixel,
and neither the order in which fragments are found nor the number of workers can change a picture. Its load is the
opacity's bits, above the place along the piece, above the pixel within the tile.
"""

from __future__ import annotations

import numpy as np

from ...jit import function, inlined, inner

TILE_WIDTH = 64
TILE_HEIGHT = 16
PIXELS = TILE_WIDTH * TILE_HEIGHT
BLOCK = 64
"""Fragments a block."""
PLACES = 22
"""Bits of the place along a strand from a lit vertex to the next; those of the pixel take the rest of 32."""
READY = 384
"""Fragments that are appended at once."""
# Rows of what is told of each: depth number and opacity; column and row of the picture, index of the piece's first
# vertex, and place from the lit vertex before, in units of 2^-PLACES of the way to the next.
DEPTH, ALPHA = (i * READY for i in range(2))
X, Y, VERTEX, PLACE = (i * READY for i in range(4))

ZERO = np.float32(0.0)
LOW = np.int64(0xFFFFFFFF)
NEAREST = np.int64(0x7FFFFFFF)
"""No less than the bits of any number that is not negative: keys are not negative."""
SHIFT = np.int64(32)
PIXEL_BITS = np.int64(32 - PLACES)
IN_PIXEL = np.int64(PIXELS - 1)
IN_BLOCK = np.int64(BLOCK - 1)
BLOCK_BITS = np.int64(6)
COLUMN_BITS, IN_ROW = np.int64(6), np.int64(TILE_WIDTH - 1)
ROW_BITS, IN_COLUMN = np.int64(4), np.int64(TILE_HEIGHT - 1)
UNIT = np.float32(2.0**-PLACES)


@inner
def append(ready, places, n, top, across, pool, links, heads, fills, used, begin, last, task):
    """Append fragments to a worker's chains.

    ready (2 * READY,) float32 and places (4 * READY,) int32: the first n fragments of the picture, in rows as listed
    above; top: first row of the tiles; across: tiles side by side;
    pool (blocks * BLOCK, 2) int64; links (blocks,) int64: the block after each; heads, fills (workers, tiles) int64:
    the first block of each chain, and the slot after its last fragment, 0 where there is none; used (workers,) int64:
    blocks that were asked for; begin, last: the worker's own, of which the last is only a place for what finds no
    room.
    """
    for i in range(n):
        x = np.int64(places[X + i])
        y = np.int64(places[Y + i]) - top
        tile = (y >> ROW_BITS) * across + (x >> COLUMN_BITS)
        slot = fills[task, tile]
        if slot & IN_BLOCK == 0:
            slot = link(slot, tile, links, heads, used, begin, last, task)
        fills[task, tile] = slot + 1
        pool[slot, 0] = key_of(ready[DEPTH + i], np.int64(places[VERTEX + i]))
        pixel = (y & IN_COLUMN) << COLUMN_BITS | x & IN_ROW
        alpha = np.int64(np.float32(ready[ALPHA + i]).view(np.uint32))
        pool[slot, 1] = alpha << SHIFT | np.int64(places[PLACE + i]) << PIXEL_BITS | pixel


@inner
def link(slot, tile, links, heads, used, begin, last, task):
    """The first slot of another block for a worker's chain in a tile, where the last one is full; all as in `append`.
    A function of its own: what is handed arrays counts references, which a fragment cannot afford."""
    block = min(begin + used[task], last)
    used[task] += 1
    if slot == 0:
        heads[task, tile] = block
    else:
        links[(slot - 1) >> BLOCK_BITS] = block
    return block << BLOCK_BITS


@inlined
def key_of(depth, index):
    """What a fragment is sorted by."""
    # rounding may take a depth number below zero, whose bits would pass for near
    number = np.int64(np.float32(depth if depth > ZERO else ZERO).view(np.uint32))
    return (NEAREST - number) << SHIFT | index


@inner
def depth_of(key):
    """A fragment's depth number."""
    return np.uint32(NEAREST - (key >> SHIFT)).view(np.float32)


@inner
def opacity_of(load):
    """A fragment's opacity."""
    return np.uint32(load >> SHIFT).view(np.float32)


@inner
def place_of(load):
    """A fragment's place from the lit vertex before, in units of 2^-PLACES of the way to the next."""
    return (load & LOW) >> PIXEL_BITS


@function
def fixed(t, past, bits):
    """The place of a fragment, as it is kept: at t of its piece, 0 to 1, that is number `past` after a lit vertex, of
    2^(PLACES − bits) until the next."""
    most = np.int64(1) << bits
    return past << bits | min(np.int64(t * np.float32(most)), most - 1)
