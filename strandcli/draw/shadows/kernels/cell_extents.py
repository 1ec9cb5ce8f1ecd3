"""Nearest and farthest strand of each cell of an opacity map (see `opacity`).

They come from places on the strands, two texels apart at the most, each in one cell. `splats` adds to cells beside
these, too: a cell without a place of its own has the extents of its eight neighbours, whose places are within two
texels. A strand that only grazes a cell may lie in front of its extents, where it counts in the first layer, or behind
them, in the last.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, function, parallel, prange
from .minmax import FARTHEST, NEAREST
from .splats import count_spots

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)


@device
def widen(begin, end, scale, window, extents):
    """Widen the extents of the cells in the window that hold places of a segment, at most two texels apart.

    begin, end: x and y, texels, and depth, metres; scale: texels a metre; extents (cells, 2): of `splats.OpacityMap`.
    """
    x, y, d = begin
    dx, dy, rise = end[0] - x, end[1] - y, end[2] - d
    spots = count_spots(dx, dy, rise, scale, window.width, TWO)
    per = ONE / np.float32(max(spots, 1))
    thick = HALF * per * abs(rise)
    half = np.int64(window.width >> 1)
    last = np.float32(window.width) - HALF
    for spot in range(spots):
        t = (np.float32(spot) + HALF) * per
        # footprints of strands just beside the map reach into it
        row = np.int64(min(y + t * dy, last)) if y + t * dy < last + TWO else np.int64(-1)
        if row < window.top or row >= window.bottom:
            continue
        column = np.int64(min(max(x + t * dx, ZERO), last))
        cell = np.uint64((row >> 1) * half + (column >> 1))
        depth = d + t * rise
        extents[cell, NEAREST] = min(extents[cell, NEAREST], depth - thick)
        extents[cell, FARTHEST] = max(extents[cell, FARTHEST], depth + thick)


@parallel
def fill_gaps(own, half, extents):
    """Write the extents of each cell to extents (half * half, 2), metres: its own, or where it holds no place those of
    its eight neighbours together. own: (inf, −inf) in cells without a place; half: cells along a side of the map."""
    for row in prange(half):
        for column in range(half):
            cell = np.int64(row) * half + column
            near, far = own[cell, NEAREST], own[cell, FARTHEST]
            if near > far:
                for r in range(max(np.int64(row) - 1, 0), min(np.int64(row) + 2, half)):
                    for c in range(max(column - 1, 0), min(column + 2, half)):
                        near = min(near, own[r * half + c, NEAREST])
                        far = max(far, own[r * half + c, FARTHEST])
            extents[cell, NEAREST] = near
            extents[cell, FARTHEST] = far


@function
def number_cells(extents, rows):
    """Number the cells that contain strands from 1 on; return how many there are.

    extents (cells, 2): of `OpacityMap`; rows (cells,) out: the numbers, 0 for empty cells. float32 represents every
    integer up to the greatest number of cells.
    """
    count = np.int64(0)
    for cell in range(extents.shape[0]):
        there = extents[cell, NEAREST] <= extents[cell, FARTHEST]
        count += np.int64(there)
        rows[cell] = np.float32(count) if there else ZERO
    return count
