"""Exact area that thin segments of strands cover of each pixel, however thin they are.

A segment is a band around its axis. Along the screen axis to which it is more nearly parallel, the picture is divided
into cells: strips one pixel long that the band crosses, in the figure from left to right with the slope s. Within a
cell, the distribution of the band's area over height is a box (the band's height, 2 h) convolved with another (the rise
within the cell, s), so the share of the area below the border of a row is the integral of a trapezoid:

    row + 1 ______________                          ____
                       _.-'   axis                 /    \\     distribution of the band's area over height
                  _.-'                        ____/      \\____
    row     ___-'_________                       |a  b
                                                 a = h + s / 2, b = |h − s / 2|

The shares of rows are differences of this integral, so they add up to the band's area exactly. A band thinner than an
eighth of a pixel is drawn with that width and proportionally less opacity, and a slope of less than 1/16 as 1/16:
single precision needs it, and the difference is invisible.

A run is a sequence of thin segments of one strand of the same kind (`segments`): parallel to the same screen axis, in
the same direction. Each cell of a run is drawn once, by the segment that leaves it, and the cells at its ends in
proportion to the length inside. So no joint is counted twice, and a strand covers its length times its width.

Cells of many segments are collected, so that computations without branches run as vector code over all of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import VECTOR
from ....jit import device, inlined
from ....simd import half_width_pointer, load, movemask, store
from ...common.kernels.numbers import HALF, ONE, ZERO
from .crowds import count_visible
from .tiles import AT_DEPTH, AT_OPACITY, AT_PLACE, AT_VERTEX, NUMBERS, PIXEL_BITS, ROW_BITS

FLAT = np.float32(1 / 16)
FAINT = np.float32(1e-5)
"""Share of a cell that is not worth a fragment."""
FAR = np.float32(1e9)

CELLS = 128
"""Greatest number of cells that are collected."""
# Rows of float32, one number a cell: depth number; coordinate across of the axis, in the middle of the cell; area of
# the band × opacity; rise of the axis within the cell; half the band's height; position along the segment, 0 to 1;
# number of the cell; the lowest row across that it touches, and the opacity in that row and the next two.
DEPTH, MIDDLE, AREA, RISE, H, ALONG, CELL, ROW, COVERED = (i * CELLS for i in range(9))
CHOSEN = 11 * CELLS
"""List of the covered entries of the three rows from `COVERED` on, as row · `CELLS` + cell."""
ROWS = 15
# Rows of int32, one number a cell: −1 if the segment is more nearly parallel to x, 0 if to y; its first vertex; the
# position along the strand as in `tiles`; and for each of the three rows the pixel within the tile.
FLAT_MASK, VERTEX, PLACE, PIXEL = (i * CELLS for i in range(4))
INTEGERS = 6
"""Rows of int32."""
IN_CELLS = np.uint64(CELLS - 1)

LANES = VECTOR // 2 // 4
"""Lanes of the vectors of a `half_width_pointer`."""


def _lane_lists() -> NDArray[np.float32]:
    """Return (2^LANES, LANES): for each bit mask of lanes, the numbers of the set ones, then zeros."""
    table = np.zeros((1 << LANES, LANES), np.float32)
    for bits, row in enumerate(table):
        lanes = [lane for lane in range(LANES) if bits >> lane & 1]
        row[: len(lanes)] = lanes
    return table


LIST_STRIDE = np.uint64(LANES)
LANE_LISTS = _lane_lists()
LANE_COUNTS = np.array([bits.bit_count() for bits in range(1 << LANES)], np.uint8)
"""Set bits of each mask."""


class Target(NamedTuple):
    """The tile for which fragments are found, the rows top <= y < bottom and columns left <= x < right, and the
    fragments."""

    top: int
    bottom: int
    left: int
    right: int
    place_bits: int
    """As in `tiles.Fragments`."""
    occlusion_depth: NDArray[np.float32]
    """(PIXELS,) depth number behind which nothing is visible; 0: all is."""
    found: NDArray[np.int32]
    """(capacity * `NUMBERS`,) fragments, with the columns of `tiles`; those beyond the capacity are lost."""
    counts: NDArray[np.int32]
    """(PIXELS,) number of fragments of each pixel."""
    opaque: np.float32
    """Transmittance below which nothing is seen, less something for rounding; 0: all is seen."""
    through: NDArray[np.float32]
    """(PIXELS,) product of 1 − opacity of each pixel's latest visible fragments."""
    least: NDArray[np.float32]
    """(PIXELS,) least depth number of these fragments (see `crowds.count_visible`)."""
    blocks: NDArray[np.int32]
    """(PIXELS,) scratch."""
    windows: NDArray[np.float32]
    """(`tiles.WINDOWS`,) depth numbers behind which nothing in parts of the tile is visible."""
    widest: NDArray[np.float32]
    """(1,) greatest width of the wide segments so far, samples."""


class Work(NamedTuple):
    """Scratch arrays for segments and cells."""

    segments: NDArray[np.float32]
    """(`segments.ROWS` * `segments.ROW`,)"""
    cells: NDArray[np.float32]
    """(ROWS * CELLS,)"""
    numbers: NDArray[np.int32]
    """(INTEGERS * CELLS,) integers of cells."""
    ribbon: NDArray[np.float32]
    """(`ribbon.ROWS` * `ribbon.ROW`,) pixels of a wide segment."""


@inlined
def write_fragment(found, o, depth, alpha, vertex, place, pixel):
    """Write a fragment behind the first o of `Target.found`; beyond the capacity the last one is overwritten.

    depth: depth number; alpha: opacity; vertex, place: of its segment, as in `tiles`; pixel: within the tile.
    """
    at = min(np.uint64(o), np.uint64(found.shape[0] // NUMBERS - 1)) * np.uint64(NUMBERS)
    found[at + AT_DEPTH] = np.float32(depth).view(np.int32)
    found[at + AT_OPACITY] = np.float32(alpha).view(np.int32)
    found[at + AT_VERTEX] = vertex
    found[at + AT_PLACE] = place << PIXEL_BITS | pixel


@device
def cover_cells(work, n, target, m):
    """Append the fragments of the first n cells that no solid hides to the m found so far; return their new number.

    Each fragment is written, and the end of the list advances only past visible ones: a branch could not be predicted.
    """
    cells = work.cells
    numbers = work.numbers
    found = target.found
    cover(cells, n)
    locate(cells, numbers, n, target)
    o = np.uint64(m)
    for i in range(np.uint64(list_covered(cells, n))):
        which = np.uint64(np.int64(cells[np.uint64(CHOSEN) + i]))
        k = which & IN_CELLS
        pixel = numbers[np.uint64(PIXEL) + which]
        depth, alpha = cells[np.uint64(DEPTH) + k], cells[np.uint64(COVERED) + which]
        vertex, place = numbers[np.uint64(VERTEX) + k], numbers[np.uint64(PLACE) + k]
        write_fragment(found, o, depth, alpha, vertex, place, pixel)
        visible = count_visible(target, np.uint64(pixel), depth, alpha)
        o += np.uint64(visible)
    return np.int64(o)


@device
def locate(work, cells, n, target):
    """Store the pixels within the tile of the three rows of each of the first n cells, and set the opacity of those
    outside to 0; add the position along the segment to `PLACE`, before that of the segment's beginning."""
    most = np.int32(np.int64(1) << target.place_bits) - np.int32(1)
    fine = np.float32(most) + ONE
    wide = np.uint32(target.right - target.left)
    tall = np.uint32(target.bottom - target.top)
    left = np.int32(target.left)
    top = np.int32(target.top)
    for k in range(n):
        cells[PLACE + k] += min(np.int32(work[ALONG + k] * fine), most)
        along = np.int32(work[CELL + k])
        flat_mask = cells[FLAT_MASK + k]
        over = np.int32(work[ROW + k])
        cells[PIXEL + k], inside = pixel_of(along, over, flat_mask, left, top, wide, tall)
        work[COVERED + k] = work[COVERED + k] if inside else ZERO
        over = np.int32(over + np.int32(1))
        cells[PIXEL + CELLS + k], inside = pixel_of(along, over, flat_mask, left, top, wide, tall)
        work[COVERED + CELLS + k] = work[COVERED + CELLS + k] if inside else ZERO
        over = np.int32(over + np.int32(1))
        cells[PIXEL + 2 * CELLS + k], inside = pixel_of(along, over, flat_mask, left, top, wide, tall)
        work[COVERED + 2 * CELLS + k] = work[COVERED + 2 * CELLS + k] if inside else ZERO


@inlined
def pixel_of(along, over, flat_mask, left, top, wide, tall):
    """Return a pixel within the tile, and whether it is inside; along, over: column and row if `flat_mask` is −1, row
    and column if 0."""
    swap = np.int32((along ^ over) & flat_mask)
    x = np.int32(np.int32(over ^ swap) - left)
    y = np.int32(np.int32(along ^ swap) - top)
    return np.int32(np.int32(y << np.int32(ROW_BITS)) | x), (np.uint32(x) < wide) & (np.uint32(y) < tall)


@device
def cover(work, n):
    """Store the lowest row and the opacity in three rows of each of the first n cells."""
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
        one = share_below(d, a, b, norm)
        two = share_below(d + ONE, a, b, norm)
        area = work[AREA + k]
        work[ROW + k] = row
        work[COVERED + k] = min(area * one, ONE) if one > FAINT else ZERO
        work[COVERED + CELLS + k] = min(area * (two - one), ONE) if two - one > FAINT else ZERO
        work[COVERED + 2 * CELLS + k] = min(area * (ONE - two), ONE) if ONE - two > FAINT else ZERO


@inlined
def share_below(d, a, b, norm):
    """Return the share of a cell's band that lies at most d above its axis: the integral of the trapezoid."""
    e = abs(d)
    outer = max(a - e, ZERO)
    inner = max(b - e, ZERO)
    tail = (outer * outer - inner * inner) * norm
    return tail if d < ZERO else ONE - tail


@device
def list_covered(work, n):
    """List the covered entries of the first n cells, row by row; return their number.

    Which are covered cannot be predicted, so there is no branch: the mask of a vector of entries is the index in a
    table of lane numbers."""
    rows = half_width_pointer(work)
    lists = half_width_pointer(LANE_LISTS)
    chosen = np.uint64(0)
    for row in range(3):
        begin = COVERED + row * CELLS
        for k in range(n, min(n + LANES, CELLS)):
            work[begin + k] = ZERO
        for first in range(0, n, LANES):
            bits = movemask(load(rows, begin + first) > ZERO)
            lanes = load(lists, bits * LIST_STRIDE)
            store(rows, np.uint64(CHOSEN) + chosen, lanes + np.float32(row * CELLS + first))
            chosen += np.uint64(LANE_COUNTS[bits])
    return chosen
