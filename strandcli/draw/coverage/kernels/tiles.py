"""Tiles of a picture, and the fragments that a strand leaves in one.

A tile is `TILE_HEIGHT` rows of `TILE_WIDTH` pixels, few enough for all its fragments to stay in a core's own cache
while they are found, sorted and weighed: written to memory by the million and read again, they take as long as half of
what is computed. What goes to the tiles first is which parts of strands lie in each.

A fragment is four 32-bit numbers: the bits of its depth number and of its opacity, the index of its piece's first
vertex, and its place along the piece above its pixel within the tile. A piece touches a pixel once, so that depth and
index differ within a pixel, and neither the order in which fragments are found nor the number of workers can change a
picture.
"""

from __future__ import annotations

import numpy as np

from ....jit import function, inlined

TILE_WIDTH = 32
TILE_HEIGHT = 32
PIXELS = TILE_WIDTH * TILE_HEIGHT
PLACES = 22
"""Bits of the place along a strand from a lit vertex to the next; those of the pixel take the rest of 32."""
NUMBERS = 4
"""Of a fragment: depth, opacity, index, and place and pixel."""

ZERO = np.float32(0.0)
PIXEL_BITS = 32 - PLACES
ROW_BITS = 5
"""A pixel's row lies above so many bits of its column."""
UNIT = np.float32(2.0**-PLACES)
THIN = np.float32(1 / 16)
"""Half the least height of a band that is drawn, pixels (see `coverage`)."""


@function
def fixed(t, past, bits):
    """The place of a fragment, as it is kept: at t of its piece, 0 to 1, that is number `past` after a lit vertex, of
    2^(PLACES − bits) until the next."""
    most = np.int64(1) << bits
    return past << bits | min(np.int64(t * np.float32(most)), most - 1)


@inlined
def corner(tile, width, top):
    """The first row and the first column of a tile, of those of a picture so wide from the row `top` on."""
    across = (width + TILE_WIDTH - 1) // TILE_WIDTH
    return top + tile // across * TILE_HEIGHT, tile % across * TILE_WIDTH
