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

from ....jit import device, inlined
from ....simd import floor, where
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


BLOCK = 4
"""Pixels of a block's side."""
ACROSS, DOWN = TILE_WIDTH // BLOCK, TILE_HEIGHT // BLOCK
"""Blocks of a tile."""
SPAN = 3
"""Blocks of a window's side."""
WHOLE = ACROSS * DOWN
"""Number of the window that is the whole tile."""
WINDOWS = WHOLE + 1
SAFE = np.float32(1 - 1e-6)
"""Factor of depth numbers, so that rounding hides nothing visible."""
PER_PIXEL = np.float32(1 / BLOCK)
REACH = np.float32(BLOCK * SPAN)
SPANNED = np.float32(SPAN)
OF_TILE = np.float32(ACROSS), np.float32(DOWN)
"""Blocks of a tile across and down, as `window_of` takes them."""
FARTHEST = np.int32(np.float32(np.inf).view(np.int32))
MOST = 1 << 24
"""Windows of a picture are numbered by whole numbers in single precision, which are exact up to here."""


class PictureWindows(NamedTuple):
    """Depths behind which solids leave nothing visible in the windows of a whole picture; none if it has no solids."""

    depths: NDArray[np.float32]
    """(down * across + 1,) depth number of each window, then 0 for boxes that fit into none; (0,): none."""
    across: int
    down: int
    """Blocks of the picture."""


@device
def find_windows(depths, blocks, windows):
    """Write the depth numbers behind which nothing in each window of a tile is visible.

    depths (PIXELS,): those of its pixels, not negative; blocks (PIXELS,) int32: scratch; windows (WINDOWS,) float32.
    """
    bits = depths.view(np.int32)  # floats that are not negative compare as their bits do
    rows = BLOCK << ROW_BITS
    for y in range(DOWN):
        for x in range(np.uint64(TILE_WIDTH)):
            at = np.uint64(y * rows) + x
            least = bits[at]
            for k in range(1, BLOCK):
                least = min(least, bits[at + np.uint64(k << ROW_BITS)])
            blocks[np.uint64(y << ROW_BITS) + x] = least
        for x in range(ACROSS):
            first = np.uint64((y << ROW_BITS) + x * BLOCK)
            least = blocks[first]
            for k in range(1, BLOCK):
                least = min(least, blocks[first + np.uint64(k)])
            blocks[np.uint64((y << ROW_BITS) + x)] = least
    all_ = FARTHEST
    for y in range(DOWN):
        for x in range(ACROSS):
            least = FARTHEST
            for j in range(y, min(y + SPAN, DOWN)):
                for i in range(x, min(x + SPAN, ACROSS)):
                    least = min(least, blocks[np.uint64((j << ROW_BITS) + i)])
            windows[np.uint64(y * ACROSS + x)] = np.int32(least).view(np.float32) * SAFE
            all_ = min(all_, least)
    windows[WHOLE] = np.int32(all_).view(np.float32) * SAFE


@inlined
def window_of(left, right, up, down, blocks):
    """Return the number of the window in which boxes lie, from their sides, pixels from the corner of a tile or picture
    of so many ``blocks`` across and down, float32; the number of all blocks for those that fit into none, or have a
    side that is no number. Vectors."""
    across, tall = blocks
    x, fits_x = begin_of(left, right, across)
    y, fits_y = begin_of(up, down, tall)
    return where(fits_x & fits_y, y * across + x, across * tall)


@inlined
def begin_of(low, high, blocks):
    """Return the block, of so many, at which the window of intervals begins, and whether it reaches as far as they do.
    Vectors."""
    block = floor(min(blocks - ONE, max(ZERO, low * PER_PIXEL)))
    return block, (high < block / PER_PIXEL + REACH) | ((block >= blocks - SPANNED) & (high >= low))
