"""Tiles of a picture, and the fragments of strands in them.

A tile is `TILE_HEIGHT` rows of `TILE_WIDTH` pixels, so few that its fragments stay in a core's own cache while they are
found, sorted and composited: to write millions of fragments to memory and read them again takes half as long as the
computation. `tile_binning` first lists the segments of strands in each tile.

A fragment that has been found is four 32-bit numbers, in the columns named below. A segment has one fragment in a
pixel, so no two fragments of a pixel have the same depth and vertex, and neither the order in which fragments are found
nor the number of workers changes a picture.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import inlined
from ...common.kernels.numbers import ONE, TWO, ZERO

TILE_WIDTH = 32
TILE_HEIGHT = 32
PIXELS = TILE_WIDTH * TILE_HEIGHT
PLACES = 22
"""Bits of a fragment's position along a strand, from a lit vertex of even rank to the next of even rank."""
STEP = PLACES - 1
"""Bits of the position from a lit vertex to the next; that of the highest is 1 after one of odd rank."""
NUMBERS = 4
"""32-bit numbers of a fragment."""
AT_DEPTH, AT_OPACITY, AT_VERTEX, AT_PLACE = (np.uint64(column) for column in range(NUMBERS))
"""Columns of a fragment: bits of the depth number and of the opacity, both float32; first vertex of its segment;
position along the strand above the pixel within the tile."""
PIXEL_BITS = 32 - PLACES
"""Bits of the pixel within the tile."""
ROW_BITS = 5
"""Bits of the pixel's column, below its row."""
UNIT = np.float32(2.0**-STEP)
"""Factor from a fixed-point position to 0 … 1."""
THIN = np.float32(1 / 16)
"""Least half height of a band that is drawn, pixels (see `cells`)."""


class Fragments(NamedTuple):
    """The visible fragments in the rows top <= y < bottom of a picture, by tile and pixel, nearest first.

    `resolve.resolve` writes them. F: capacity; V: number of vertices."""

    begin: NDArray[np.int64]
    """(tiles,) index of each tile's first fragment; −1: it has none."""
    counts: NDArray[np.uint32]
    """(tiles * PIXELS,) number of fragments of each pixel."""
    vertex: NDArray[np.uint32]
    """(F,) lit vertex before the fragment, or V + e for pixel number e at a solid's edge; where ``along`` is negative,
    the only vertex that it takes light from."""
    weight: NDArray[np.float32]
    """(F,) share of the pixel's light that comes from the fragment."""
    along: NDArray[np.float32]
    """(F,) position from that lit vertex to the next, 0 to 1; of fragments that take light from one vertex alone,
    −2 less the position, in [−1, 1)."""
    closed: NDArray[np.uint8]
    """(height * width,) `resolve.CLOSED` at the pixels of which `resolve.blend` leaves out what is behind the
    fragments, and `SOLID`, too, where one of these is a solid's; 0 before."""
    stride: int
    """Every stride-th vertex of a strand is lit; a power of two."""
    place_bits: int
    """Bits of the position along one segment; the rest of `PLACES` is the segment's number after the lit vertex of even
    rank."""
    top: int
    bottom: int
    width: int
    """Width of the picture, samples."""
    widest: NDArray[np.float32]
    """(tiles,) greatest width of the wide segments that each tile was examined for, samples; 0: there were none."""
    slight: np.float32
    """What is let through before a fragment, below which it takes light from one vertex alone."""


class Tile(NamedTuple):
    """A tile of a picture: the rows top <= y < bottom, the columns left <= x < right."""

    number: int
    top: int
    bottom: int
    left: int
    right: int


@inlined
def tile_at(number, fragments):
    """Return the `Tile` with a number, counted row by row over the rows of `fragments`."""
    across = (fragments.width + TILE_WIDTH - 1) // TILE_WIDTH
    top = fragments.top + number // across * TILE_HEIGHT
    left = number % across * TILE_WIDTH
    return Tile(number, top, min(top + TILE_HEIGHT, fragments.bottom), left, min(left + TILE_WIDTH, fragments.width))


@inlined
def between(vertex, along, stride):
    """Return the lit vertex before a fragment and the position from there to the next, 0 to 1, of what `Fragments`
    hold."""
    if along >= ZERO:
        return vertex, along
    offset = -TWO - along
    return (vertex, offset) if offset >= ZERO else (vertex - stride, offset + ONE)
