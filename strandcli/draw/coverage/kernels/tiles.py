"""Tiles of a picture, and the fragments that strands leave in one.

A tile is `TILE_HEIGHT` rows of `TILE_WIDTH` pixels, few enough for all its fragments to stay in a core's own cache
while they are found, sorted and composited: written to memory by the million and read again, they take as long as half
of what is computed. What goes to the tiles first is which segments of strands lie in each (`tile_binning`).

A fragment that has been found is four 32-bit numbers: the bits of its depth number and of its opacity, the index of its
segment's first vertex, and its place along the segment above its pixel within the tile. A segment touches a pixel once,
so depth and index differ within a pixel, and neither the order in which fragments are found nor the number of workers
changes a picture.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
"""Half the least height of a band that is drawn, pixels (see `cells`)."""


class Fragments(NamedTuple):
    """The fragments that matter in the rows top <= y < bottom of a picture, sorted: tile after tile, pixel after pixel,
    nearest first. `resolve.resolve` writes them; F is what there is room for, V counts vertices."""

    begin: NDArray[np.int64]
    """(tiles,) where each tile's fragments begin; −1 where it has none."""
    kept: NDArray[np.uint32]
    """(tiles * PIXELS,) fragments of each pixel."""
    place: NDArray[np.uint32]
    """(F,) the lit vertex before the fragment, or V + e for pixel number e at a solid's edge."""
    weight: NDArray[np.float32]
    """(F,) the share of the pixel's light that comes from it."""
    along: NDArray[np.float32]
    """(F,) its place from that lit vertex to the next, 0 to 1."""
    seen: NDArray[np.uint64]
    """(F,) the points of its sample that it shows (see `masks`); (0,) where every fragment shows all points."""
    stride: int
    """Every so-manieth vertex of a strand is lit: a power of two."""
    place_bits: int
    """A segment has 2^place_bits places, of the 2^`PLACES` from a lit vertex to the next."""
    top: int
    bottom: int
    width: int
    """Of the picture, samples."""


class Tile(NamedTuple):
    """A tile of a picture: the rows top <= y < bottom, the columns left <= x < right."""

    number: int
    top: int
    bottom: int
    left: int
    right: int


@function
def fixed(t, past, bits):
    """The place of a fragment, as it is kept: at t of its piece, 0 to 1, that is number `past` after a lit vertex, of
    2^(PLACES − bits) until the next."""
    most = np.int64(1) << bits
    return past << bits | min(np.int64(t * np.float32(most)), most - 1)


@inlined
def tile_at(number, fragments):
    """A tile by its number, of those that `fragments` cover row by row."""
    across = (fragments.width + TILE_WIDTH - 1) // TILE_WIDTH
    top = fragments.top + number // across * TILE_HEIGHT
    left = number % across * TILE_WIDTH
    return Tile(number, top, min(top + TILE_HEIGHT, fragments.bottom), left, min(left + TILE_WIDTH, fragments.width))
