"""Depths behind which nothing is visible in parts of a tile or picture, for segments that are left out.

Segments that solids hide are never binned into tiles; those that strands hide are left out before they are drawn. A
tile is divided into blocks of pixels, and a window is `SPAN` blocks wide and tall, or less at the tile's right and
lower sides. A short segment lies within the window that begins at its upper left block; if it lies behind the least
depth of any pixel there, nothing of it is visible.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined
from ....simd import floor, where
from ...common.kernels.numbers import ONE, ZERO
from .tiles import ROW_BITS, TILE_HEIGHT, TILE_WIDTH

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
