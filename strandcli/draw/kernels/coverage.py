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

import numpy as np

from ...jit import inlined, inner
from . import tiles

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
THIN = np.float32(1 / 16)
FLAT = np.float32(1 / 16)
FAINT = np.float32(1e-5)
"""Share of a cell that is not worth a fragment."""
FAR = np.float32(1e9)

CELLS = 128
# Rows of numbers, one a cell: depth number, height of the middle line above the first row of the picture, area, rise
# within the cell, half the band's height; the lowest row that it touches, and what it covers of that and the next two.
DEPTH, MIDDLE, AREA, RISE, H, ROW, COVERED = (i * CELLS for i in range(7))
ROWS = 9
# Column or row of the cell, whether the piece follows x, index of its first vertex, place as in `tiles`; cells chosen.
CELL, FLAT_WAY, VERTEX, PLACE, CHOSEN = (i * CELLS for i in range(5))
INTEGERS = 7
IN_CELLS, CELL_BITS = np.int64(CELLS - 1), np.int64(7)


@inner
def fragments(work, cells, n, top, bottom, width, hides, ready, places):
    """What the first n cells cover of the rows top <= y < bottom, as fragments in ready and places (see
    `tiles.append`), but for those that a solid hides. Returns how many.

    hides (height * width,) float32: depth number in front of which nothing is hidden, or None. Which fragments stay is
    hard to guess: each is written, and kept or not.
    """
    cover(work, n)
    chosen = choose(work, cells, n)
    m = np.int64(0)
    for i in range(chosen):
        which = np.int64(cells[CHOSEN + i])
        k = which & IN_CELLS
        row = np.int64(work[ROW + k]) + (which >> CELL_BITS)
        cell = np.int64(cells[CELL + k])
        flat = cells[FLAT_WAY + k] != 0
        x = cell if flat else row
        y = row if flat else cell
        places[tiles.X + m] = x
        places[tiles.Y + m] = y
        places[tiles.VERTEX + m] = cells[VERTEX + k]
        places[tiles.PLACE + m] = cells[PLACE + k]
        q = work[DEPTH + k]
        ready[tiles.DEPTH + m] = q
        ready[tiles.ALPHA + m] = work[COVERED + which]
        kept = (x >= 0) & (x < width) & (y >= top) & (y < bottom)
        if hides is not None:
            kept &= q >= hides[np.uint64(y * width + x if kept else 0)]
        m += np.int64(kept)
    return m


@inner
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


@inner
def choose(work, cells, n):
    """List where anything is covered: which is as good as random, so that each is written and kept or not."""
    chosen = np.int64(0)
    for row in range(3):
        for k in range(n):
            cells[CHOSEN + chosen] = row * CELLS + k
            chosen += np.int64(work[COVERED + row * CELLS + k] > ZERO)
    return chosen


@inlined
def whole(x):
    """The greatest whole number that is no greater than x: the library's is a call, for which registers are saved."""
    i = np.int64(x)
    return i - np.int64(np.float32(i) > x)
