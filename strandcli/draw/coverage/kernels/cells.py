"""How much of a pixel's box a thin piece of a strand covers: exactly, however thin it is.

A piece is a band about its middle line. Seen along the axis that the piece follows more, a pixel is a cell: a strip one
pixel long that the band crosses, in the figure from left to right with the slope s. How far the band lies above the
rows' borders within the cell is a box (the band's height, 2 h) averaged over another (the rise within the cell, s), so
that the share of its area under a border is a trapezoid's integral:

    row + 1 ______________                          ____
                       _.-'   middle line          /    \\     what of the band's area lies at which height
                  _.-'                        ____/      \\____
    row     ___-'_________                       |a  b
                                                 a = h + s / 2, b = |h − s / 2|

Shares of neighbouring rows are differences of that integral, so they add up to the band's area exactly. A band thinner
than an eighth of a pixel is drawn that wide and as much paler, and a slope of less than 1/16 as that: single precision
needs it, and nobody sees it.

Thin pieces of one strand that follow the same axis the same way are a run. Each cell of a run is drawn once, by the
piece that leaves it, its ends by what they cover of their cells: no joint is counted twice, and the area of a strand is
its length times its width.

Cells are gathered from many pieces, and what has no branches is one loop over them, which becomes vector code.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import VECTOR
from ....jit import device, inlined
from ....simd import half_width_pointer, load, movemask, store
from .tiles import NUMBERS, PIXEL_BITS, ROW_BITS

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
FLAT = np.float32(1 / 16)
FAINT = np.float32(1e-5)
"""Share of a cell that is not worth a fragment."""
FAR = np.float32(1e9)

CELLS = 128
# Rows of numbers, one a cell: depth number, height of the middle line above the first row of the picture, area, rise
# within the cell, half the band's height, place along the piece, column or row of the cell; the lowest row that it
# touches, and what it covers of that and the next two; the cells and rows chosen.
DEPTH, MIDDLE, AREA, RISE, H, ALONG, CELL, ROW, COVERED = (i * CELLS for i in range(9))
CHOSEN = 11 * CELLS
ROWS = 15
# −1 where the piece follows x and 0 where y, index of its first vertex, place as in `tiles`; for each of the three rows
# the pixel within the tile.
FLAT_WAY, VERTEX, PLACE, PIXEL = (i * CELLS for i in range(4))
INTEGERS = 6
IN_CELLS = np.uint64(CELLS - 1)

LANES = VECTOR // 2 // 4
"""Of the vectors of a `half_width_pointer`."""


def _lane_lists() -> NDArray[np.float32]:
    """(2^LANES, LANES) for each pattern of lanes their numbers, one after the other."""
    table = np.zeros((1 << LANES, LANES), np.float32)
    for bits, row in enumerate(table):
        lanes = [lane for lane in range(LANES) if bits >> lane & 1]
        row[: len(lanes)] = lanes
    return table


EACH = np.uint64(LANES)
LISTED = _lane_lists()
HOW_MANY = np.array([bits.bit_count() for bits in range(1 << LANES)], np.uint8)


class Target(NamedTuple):
    """The tile whose fragments are found: the rows top <= y < bottom, the columns left <= x < right."""

    top: int
    bottom: int
    left: int
    right: int
    place_bits: int
    """As in `tiles.Fragments`."""
    occlusion_depth: NDArray[np.float32]
    """(PIXELS,) depth number behind which nothing is seen; 0 where all is."""
    found: NDArray[np.int32]
    """(capacity * `NUMBERS`,) the fragments, as many as find room."""
    counts: NDArray[np.int32]
    """(PIXELS,) fragments of each pixel."""


class Work(NamedTuple):
    """What segments and cells are worked on in."""

    segments: NDArray[np.float32]
    """(`segments.ROWS` * `segments.ROW`,)"""
    cells: NDArray[np.float32]
    """(ROWS * CELLS,)"""
    numbers: NDArray[np.int32]
    """(INTEGERS * CELLS,) what of cells is whole."""


@inlined
def add_fragment(target, m, depth, alpha, vertex, place, pixel):
    """Add a fragment to the m found before, of which as many are kept as find room; returns m + 1.

    target: `Target`; vertex, place: of its segment as in `tiles`; pixel: within the tile.
    """
    o = min(m, np.int64(target.found.shape[0] // NUMBERS - 1)) * NUMBERS
    target.found[o] = np.float32(depth).view(np.int32)
    target.found[o + 1] = np.float32(alpha).view(np.int32)
    target.found[o + 2] = vertex
    target.found[o + 3] = place << PIXEL_BITS | pixel
    target.counts[pixel] += 1
    return m + 1


@device
def cover_cells(work, n, target, m):
    """Add what the first n cells cover of a tile, but for what a solid hides, to the m fragments found before; returns
    how many there are then.

    Which pixels stay is hard to guess: each is written, and kept or not.
    """
    cells = work.cells
    numbers = work.numbers
    found = target.found
    cover(cells, n)
    locate(cells, numbers, n, target)
    room = np.uint64(found.shape[0] // NUMBERS - 1)
    o = np.uint64(m)
    for i in range(np.uint64(choose(cells, n))):
        which = np.uint64(np.int64(cells[np.uint64(CHOSEN) + i]))
        k = which & IN_CELLS
        pixel = numbers[np.uint64(PIXEL) + which]
        depth = cells[np.uint64(DEPTH) + k]
        at = min(o, room) * np.uint64(NUMBERS)
        found[at] = np.float32(depth).view(np.int32)
        found[at + np.uint64(1)] = np.float32(cells[np.uint64(COVERED) + which]).view(np.int32)
        found[at + np.uint64(2)] = numbers[np.uint64(VERTEX) + k]
        found[at + np.uint64(3)] = numbers[np.uint64(PLACE) + k] << PIXEL_BITS | pixel
        seen = depth >= target.occlusion_depth[np.uint64(pixel)]
        target.counts[np.uint64(pixel)] += np.int64(seen)
        o += np.uint64(seen)
    return np.int64(o)


@device
def locate(work, cells, n, target):
    """Where in the tile the three pixels of each of the first n cells lie; those outside of it are not covered. And
    where on their strand, `PLACE` having been that of the segment."""
    most = np.int32(np.int64(1) << target.place_bits) - np.int32(1)
    fine = np.float32(most) + ONE
    wide = np.uint32(target.right - target.left)
    tall = np.uint32(target.bottom - target.top)
    left = np.int32(target.left)
    top = np.int32(target.top)
    for k in range(n):
        cells[PLACE + k] += min(np.int32(work[ALONG + k] * fine), most)
        along = np.int32(work[CELL + k])
        way = cells[FLAT_WAY + k]
        over = np.int32(work[ROW + k])
        cells[PIXEL + k], inside = pixel_of(along, over, way, left, top, wide, tall)
        work[COVERED + k] = work[COVERED + k] if inside else ZERO
        over = np.int32(over + np.int32(1))
        cells[PIXEL + CELLS + k], inside = pixel_of(along, over, way, left, top, wide, tall)
        work[COVERED + CELLS + k] = work[COVERED + CELLS + k] if inside else ZERO
        over = np.int32(over + np.int32(1))
        cells[PIXEL + 2 * CELLS + k], inside = pixel_of(along, over, way, left, top, wide, tall)
        work[COVERED + 2 * CELLS + k] = work[COVERED + 2 * CELLS + k] if inside else ZERO


@inlined
def pixel_of(along, over, way, left, top, wide, tall):
    """A pixel of the tile and whether it is inside, by column and row or the other way about."""
    swap = np.int32((along ^ over) & way)
    x = np.int32(np.int32(over ^ swap) - left)
    y = np.int32(np.int32(along ^ swap) - top)
    return np.int32(np.int32(y << np.int32(ROW_BITS)) | x), (np.uint32(x) < wide) & (np.uint32(y) < tall)


@device
def cover(work, n):
    """What the first n cells cover of three rows each."""
    for k in range(n):
        h = work[H + k]
        spread = max(work[RISE + k], FLAT)
        a = h + HALF * spread
        b = abs(h - HALF * spread)
        norm = HALF * HALF / (h * spread)  # makes the trapezoid's area one
        middle = min(max(work[MIDDLE + k], -FAR), FAR)
        low = middle - a
        row = np.float32(np.int32(low))
        row -= ONE if row > low else ZERO
        d = row + ONE - middle
        one = below(d, a, b, norm)
        two = below(d + ONE, a, b, norm)
        area = work[AREA + k]
        work[ROW + k] = row
        work[COVERED + k] = min(area * one, ONE) if one > FAINT else ZERO
        work[COVERED + CELLS + k] = min(area * (two - one), ONE) if two - one > FAINT else ZERO
        work[COVERED + 2 * CELLS + k] = min(area * (ONE - two), ONE) if ONE - two > FAINT else ZERO


@inlined
def below(d, a, b, norm):
    """Share of a cell's band that lies no more than d above its middle."""
    e = abs(d)
    outer = max(a - e, ZERO)
    inner = max(b - e, ZERO)
    tail = (outer * outer - inner * inner) * norm
    return tail if d < ZERO else ONE - tail


@device
def choose(work, n):
    """List where anything is covered, row by row: which is as good as random, so that nothing is asked of each, but of
    some at once, whose pattern tells what to list."""
    rows = half_width_pointer(work)
    lists = half_width_pointer(LISTED)
    chosen = np.uint64(0)
    for row in range(3):
        begin = COVERED + row * CELLS
        for k in range(n, min(n + LANES, CELLS)):
            work[begin + k] = ZERO
        for some in range(0, n, LANES):
            bits = movemask(load(rows, begin + some) > ZERO)
            store(rows, np.uint64(CHOSEN) + chosen, load(lists, bits * EACH) + np.float32(row * CELLS + some))
            chosen += np.uint64(HOW_MANY[bits])
    return chosen
