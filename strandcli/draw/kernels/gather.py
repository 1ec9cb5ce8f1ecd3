"""From parts of strands to a tile's fragments: their pieces in runs, and cells of which many are covered at once."""

from __future__ import annotations

import math

import numpy as np

from ...jit import inlined, inner
from ...simd import lay
from .coverage import (
    AREA,
    CELL,
    CELLS,
    DEPTH,
    FLAT_WAY,
    MIDDLE,
    PLACE,
    RISE,
    THIN,
    VERTEX,
    ZERO,
    H,
    fragments,
    whole,
)
from .parts import BEHIND, BLOCK, LOW, NO_WAY, RIBBON, SHIFT, WIDE, way_of
from .prefetch import prefetch
from .ribbon import ribbon
from .tiles import NUMBERS, ROW_BITS

HALF = np.float32(0.5)
ONE = np.float32(1.0)
AHEAD = np.int64(2)
"""Parts that memory is asked for before they are looked at."""
LINE = np.int64(16)
"""Numbers of a cache line."""


@inner
def gather(
    first, screen, widths, opacity, nearer, stride, bits, hides, edges, depth, cover, pool, links, heads, fills, tile,
    top, bottom, left, right, width, work, cells, veil, found, counts, marks,
):  # fmt: skip
    """Find a tile's fragments: those of its parts of strands, and of solids.

    first, screen, widths: as in `parts.share_out`; opacity: of the material; every `stride`-th vertex is lit,
    2^(PLACES − bits); hides (height * width,) float32: depth number in front of which nothing is hidden, or None;
    edges (E,) int64 in the order of rows, depth, cover (E,) float32: pixels that a solid covers in part, its depth
    number and share, which become fragments too, number V + e; pool, links, heads, fills: as `parts.share_out` leaves
    them; the tile is the rows top <= y < bottom and columns left <= x < right of a picture of this width.
    work (ROWS * CELLS,) float32, cells (INTEGERS * CELLS,) int32: to work with; veil (PIXELS,) float32: zero before, or
    what the last tile left;
    found (capacity * NUMBERS,) int32: fragments, as many as find room; counts (PIXELS,) int64: of each pixel. Returns
    how many there are. marks: not read, but soon to be written to, as all that is seen.
    """
    counts[:] = 0
    if hides is not None:
        for y in range(top, bottom):
            for x in range(left, right):
                veil[(y - top) << ROW_BITS | (x - left)] = hides[y * width + x]
    points = lay(screen)
    n = np.int64(0)
    m = solids(edges, depth, cover, screen.shape[0], top, bottom, left, right, width, found, counts)
    for one in range(heads.shape[0]):
        block = heads[one, tile]
        stop = fills[one, tile]
        while stop > 0:
            final = block == (stop - 1) // BLOCK
            for slot in range(block * BLOCK, stop if final else block * BLOCK + BLOCK):
                ask(pool, min(slot + AHEAD, pool.shape[0] - 1), first, screen, widths, marks)
                s = pool[slot, 1] >> SHIFT
                a = first[s]
                end = first[s + 1]
                low = pool[slot, 0] & LOW
                high = pool[slot, 1] & LOW
                start = np.uint32(pool[slot, 0] >> SHIFT).view(np.float32)
                run = RIBBON
                v = low - 1
                for after in range(low, end + 1):
                    # what the piece before `after` is: whether the run of the piece before `v` goes on with it
                    way = BEHIND
                    begun = ZERO
                    if after < end:
                        way, begun = way_of(
                            points[3 * after - 3], points[3 * after - 2], points[3 * after - 1],
                            points[3 * after], points[3 * after + 1], points[3 * after + 2],
                            widths is None or max(widths[after - 1], widths[after]) > WIDE,
                        )  # fmt: skip
                        if way == NO_WAY:
                            continue
                    if widths is not None:  # noqa: SIM102  a branch of its own is left out where there are none
                        if (run != RIBBON) & (run != BEHIND):
                            n, m = thin(
                                points, widths, opacity, v, (v - 1 - a) & (stride - 1), bits, run, start, way != run,
                                top, bottom, left, right, veil, work, cells, n, found, counts, m,
                            )  # fmt: skip
                    if after > high:
                        break
                    if way == RIBBON:
                        m = ribbon(
                            screen, widths, opacity, nearer, after, a, end, (after - 1 - a) & (stride - 1), bits,
                            top, bottom, left, right, veil, found, counts, m,
                        )  # fmt: skip
                    if way != run:
                        start = begun if v >= low else start
                        run = way
                    v = after
            if final:
                break
            block = links[block]
    return fragments(work, cells, n, top, bottom, left, right, veil, found, counts, m)


@inlined
def ask(pool, slot, first, screen, widths, marks):
    """Ask for what the part in a slot needs."""
    low = (pool[slot, 0] & LOW) - 1
    prefetch(first, pool[slot, 1] >> SHIFT)
    prefetch(screen, 3 * low)
    prefetch(screen, 3 * low + LINE)
    prefetch(marks, low)
    if widths is not None:
        prefetch(widths, low)


@inner
def solids(edges, depth, cover, base, top, bottom, left, right, width, found, counts):
    """What solids cover of the tile's pixels that they cover in part; returns how many these are."""
    m = np.int64(0)
    room = np.int64(found.shape[0] // NUMBERS - 1)
    for e in range(np.searchsorted(edges, top * width), np.searchsorted(edges, bottom * width)):
        x = edges[e] % width
        if left <= x < right and cover[e] > ZERO:
            pixel = (edges[e] // width - top) << ROW_BITS | (x - left)
            o = min(m, room) * NUMBERS
            found[o] = np.int32(np.float32(depth[e]).view(np.int32))
            found[o + 1] = np.int32(np.float32(cover[e]).view(np.int32))
            found[o + 2] = base + e
            found[o + 3] = pixel
            counts[pixel] += 1
            m += 1
    return m


@inlined
def thin(
    points, widths, opacity, v, lit_past, bits, run, start, closing, top, bottom, left, right, veil, work, cells, n,
    found, counts, m,
):  # fmt: skip
    """List the cells that the piece from vertex v − 1 to v leaves behind, and, `closing`, the one that its run ends in;
    covers those listed so far where there are too many.

    run: 1 along x, 2 along y, negative against the axis; start: where the run begins, in the direction of travel; n:
    cells listed before; m: fragments found before. Returns how many there are then.
    """
    x0, y0, q0 = points[3 * v - 3], points[3 * v - 2], points[3 * v - 1]
    x1, y1, q1 = points[3 * v], points[3 * v + 1], points[3 * v + 2]
    flat = abs(run) == 1
    sign = ONE if run > 0 else -ONE
    u0 = sign * (x0 if flat else y0)
    u1 = sign * (x1 if flat else y1)
    v0 = y0 if flat else x0
    v1 = y1 if flat else x1
    low = left if flat else top
    high = right if flat else bottom
    cell = max(whole(u0), low if run > 0 else -high)
    stop = min(whole(u1) + np.int64(closing), high if run > 0 else -low)
    per = ONE / (u1 - u0)
    slope = (v1 - v0) * per
    rise = q1 - q0
    w0 = widths[v - 1]
    wider = widths[v] - w0
    stretch = math.sqrt(ONE + slope * slope)
    h = max(HALF * stretch * max(w0, widths[v]), THIN)
    stretch *= opacity
    most = np.int32(np.int64(1) << bits) - np.int32(1)
    fine = np.float32(most) + ONE
    lit = np.int32(lit_past << bits)
    way = np.int32(-1 if flat else 0)
    turned = np.int32(0 if run > 0 else -1)
    rises = abs(slope)
    while cell < stop:
        if n == CELLS:
            m = fragments(work, cells, n, top, bottom, left, right, veil, found, counts, m)
            n = np.int64(0)
        here = min(stop, cell + CELLS - n)
        for c in range(cell, here):
            k = np.uint64(n)
            enter = max(np.float32(c), start)
            length = min(np.float32(c + 1), u1) - enter
            past = enter + HALF * length - u0
            t = min(max(past * per, ZERO), ONE)
            work[np.uint64(DEPTH) + k] = q0 + rise * t
            work[np.uint64(MIDDLE) + k] = v0 + slope * past
            work[np.uint64(AREA) + k] = stretch * length * (w0 + t * wider)
            work[np.uint64(RISE) + k] = rises * length
            work[np.uint64(H) + k] = h
            cells[np.uint64(PLACE) + k] = lit + min(np.int32(t * fine), most)
            cells[np.uint64(CELL) + k] = c ^ turned
            cells[np.uint64(VERTEX) + k] = v - 1
            cells[np.uint64(FLAT_WAY) + k] = way
            n += 1
        cell = here
    return n, m
