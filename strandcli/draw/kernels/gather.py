"""From parts of strands to a tile's fragments: their pieces in runs, and cells of which many are covered at once."""

from __future__ import annotations

import math

import numpy as np

from ...jit import inlined, inner
from ...simd import get, lay, put, strip
from .coverage import (
    ALONG,
    AREA,
    CELL,
    CELLS,
    DEPTH,
    FLAT_WAY,
    LANES,
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
STEPS = np.arange(LANES, dtype=np.float32)
SURE = np.float32(1 - 1e-6)
"""What is so much behind is behind, whatever the rounding."""


@inner
def gather(
    first, screen, widths, opacity, stride, bits, hides, edges, depth, cover, pool, links, heads, fills, tile,
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
    hidden = ZERO if hides is None else draw_veil(hides, top, bottom, left, right, width, veil) * SURE
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
                            widths is None or max(widths[np.uint64(after - 1)], widths[np.uint64(after)]) > WIDE,
                        )  # fmt: skip
                        if way == NO_WAY:
                            continue
                    if widths is not None:  # noqa: SIM102  a branch of its own is left out where there are none
                        if (run != RIBBON) & (run != BEHIND):
                            n, m = thin(
                                points, widths, opacity, v, (v - 1 - a) & (stride - 1), bits, run, start, way != run,
                                hidden, top, bottom, left, right, veil, work, cells, n, found, counts, m,
                            )  # fmt: skip
                    if after > high:
                        break
                    if way == RIBBON and max(points[3 * after - 1], points[3 * after + 2]) >= hidden:
                        m = ribbon(
                            screen, widths, opacity, after, a, end, (after - 1 - a) & (stride - 1), bits,
                            top, bottom, left, right, veil, found, counts, m,
                        )  # fmt: skip
                    if way != run:
                        start = begun if v >= low else start
                        run = way
                    v = after
            if final:
                break
            block = links[block]
    return fragments(work, cells, n, bits, top, bottom, left, right, veil, found, counts, m)


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
    points, widths, opacity, v, lit_past, bits, run, start, closing, hidden, top, bottom, left, right, veil, work,
    cells, n, found, counts, m,
):  # fmt: skip
    """List the cells that the piece from vertex v − 1 to v leaves behind, and, `closing`, the one that its run ends in;
    covers those listed so far where there are too many.

    run: 1 along x, 2 along y, negative against the axis; start: where the run begins, in the direction of travel;
    hidden: depth number behind which nothing is seen; n: cells listed before; m: fragments found before. Returns how
    many there are then.

    Most pieces leave few cells: a vector of them is written, and what is too many written over by the next.
    """
    x0, y0, q0 = points[3 * v - 3], points[3 * v - 2], points[3 * v - 1]
    x1, y1, q1 = points[3 * v], points[3 * v + 1], points[3 * v + 2]
    if max(q0, q1) < hidden:
        return n, m
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
    w0 = widths[np.uint64(v - 1)]
    w1 = widths[np.uint64(v)]
    stretch = math.sqrt(ONE + slope * slope)
    h = max(HALF * stretch * max(w0, w1), THIN)
    stretch *= opacity
    back = ZERO if run > 0 else ONE
    floats = strip(work)
    integers = strip(cells)
    steps = get(strip(STEPS), 0)
    while cell < stop:
        if n > CELLS - LANES:
            m = fragments(work, cells, n, bits, top, bottom, left, right, veil, found, counts, m)
            n = np.int64(0)
        here = steps + np.float32(cell)
        enter = max(here, start)
        length = min(here + ONE, u1) - enter
        past = enter + HALF * length - u0
        t = min(max(past * per, ZERO), ONE)
        put(floats, DEPTH + n, q0 + (q1 - q0) * t)
        put(floats, MIDDLE + n, v0 + slope * past)
        put(floats, AREA + n, stretch * length * (w0 + t * (w1 - w0)))
        put(floats, RISE + n, abs(slope) * length)
        put(floats, H + n, h)
        put(floats, ALONG + n, t)
        put(floats, CELL + n, sign * here - back)
        put(integers, PLACE + n, lit_past << bits)
        put(integers, VERTEX + n, v - 1)
        put(integers, FLAT_WAY + n, -np.int64(flat))
        n += min(stop - cell, LANES)
        cell += LANES
    return n, m


@inner
def draw_veil(hides, top, bottom, left, right, width, veil):
    """The depth numbers in front of which nothing is hidden, of the tile's pixels; returns the least."""
    least = np.int32(np.float32(np.inf).view(np.int32))
    for y in range(top, bottom):
        to = np.uint64((y - top) << ROW_BITS)
        at = np.uint64(y * width + left)
        for x in range(np.uint64(right - left)):
            veil[to + x] = hides[at + x]
        for x in range(np.uint64(right - left)):  # numbers that are not negative are in the order of their bits
            least = min(least, np.int32(np.float32(veil[to + x]).view(np.int32)))
    return np.int32(least).view(np.float32)
