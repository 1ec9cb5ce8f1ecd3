"""From parts of strands to a tile's fragments: their pieces in runs, and cells of which many are covered at once."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ....simd import half_width_pointer, load, pointer, store
from ...common.kernels.prefetch import prefetch
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
    VERTEX,
    ZERO,
    H,
    fragments,
)
from .ribbon import ribbon
from .segments import (
    ACROSS,
    BEGIN,
    BEHIND,
    DEEPER,
    END,
    FIRST,
    HEIGHT,
    LAST,
    NEAREST,
    NO_WAY,
    PER,
    PIECES,
    RIBBON,
    SLOPE,
    STRETCH,
    WAY,
    WIDER,
    Q,
    W,
    hold,
    look,
    take,
)
from .tile_binning import BLOCK, LOW, SHIFT
from .tiles import NUMBERS, ROW_BITS

HALF = np.float32(0.5)
ONE = np.float32(1.0)
AHEAD = np.int64(2)
"""Parts that memory is asked for before they are looked at."""
LINE = np.int64(16)
EIGHT = np.int64(8)
"""Numbers of a cache line, and of one of longer numbers."""
STEPS = np.arange(LANES, dtype=np.float32)
SURE = np.float32(1 - 1e-6)
"""What is so much behind is behind, whatever the rounding."""


@device
def gather(
    first, screen, widths, opacity, nearer, stride, bits, hides, edges, depth, cover, pool, links, heads, fills,
    tile, top, bottom, left, right, width, pieces, work, cells, veil, found, counts, marks,
):  # fmt: skip
    """Find a tile's fragments: those of its parts of strands, and of solids.

    first, screen, widths: as in `parts.share_out`; opacity: of the material; every `stride`-th vertex is lit,
    2^(PLACES − bits); hides (height * width,) float32: depth number in front of which nothing is hidden, or none;
    edges (E,) int64 in the order of rows, depth, cover (E,) float32: pixels that a solid covers in part, its depth
    number and share, which become fragments too, number V + e; pool, links, heads, fills: as `parts.share_out` leaves
    them; the tile is the rows top <= y < bottom and columns left <= x < right of a picture of this width.
    pieces (pieces.ROWS * pieces.ROW,) float32, work (ROWS * CELLS,) float32, cells (INTEGERS * CELLS,) int32: to work
    with; veil (PIXELS,) float32; found (capacity * NUMBERS,) int32: fragments, as many as find room; counts (PIXELS,)
    int64: of each pixel. Returns how many there are. marks: not read, but soon to be written to, as all that is seen.
    """
    counts[:] = 0
    hidden = ZERO
    if hides.shape[0] == 0:
        veil[:] = ZERO
    else:
        hidden = draw_veil(hides, top, bottom, left, right, width, veil) * SURE
    points = half_width_pointer(screen)
    n = np.int64(0)
    m = solids(edges, depth, cover, screen.shape[0], top, bottom, left, right, width, found, counts)
    for one in range(heads.shape[0]):
        block = heads[one, tile]
        stop = fills[one, tile]
        while stop > 0:
            final = block == (stop - 1) // BLOCK
            after = block if final else links[block]
            for line in range(0, 2 * BLOCK, EIGHT):
                prefetch(pool, 2 * BLOCK * after + line)
            for slot in range(block * BLOCK, stop if final else block * BLOCK + BLOCK):
                ask(pool, min(slot + AHEAD, pool.shape[0] - 1), first, screen, widths, marks)
                s = pool[slot, 1] >> SHIFT
                low = pool[slot, 0] & LOW
                high = pool[slot, 1] & LOW
                start = np.uint32(pool[slot, 0] >> SHIFT).view(np.float32)
                n, m = part(
                    first[s], first[s + 1], low, high, start, hidden, points, screen, widths, opacity, nearer, stride,
                    bits, top, bottom, left, right, veil, pieces, work, cells, n, found, counts, m,
                )  # fmt: skip
            if final:
                break
            block = after
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


@device
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
def part(
    a, end, low, high, start, hidden, points, screen, widths, opacity, nearer, stride, bits, top, bottom, left, right,
    veil, pieces, work, cells, n, found, counts, m,
):  # fmt: skip
    """The pieces that end in the vertices low … high of the strand a … end − 1: cells of thin ones are listed, beside
    the n before, and wide ones drawn.

    start: where the run of the first piece began; hidden: depth number behind which nothing is seen; the rest as in
    `gather`. Returns how many cells are listed then, and how many fragments were found.

    A thin piece waits for the next one, which tells whether its run goes on: points do not, nor does the strand's end.
    """
    run = RIBBON
    v = low - 1
    k = np.int64(0)
    base = low
    while True:
        count = min(max(high + 1 - base, 0) + 1, min(end - base, PIECES))
        take(points, widths, base - 1, count + 1, pieces)
        look(pieces, count, opacity)
        ends = np.int64(base + count == end)
        if ends:
            pieces[WAY + count + 1] = BEHIND
        for i in range(1, count + 1 + ends):
            way = pieces[WAY + i]
            if way == NO_WAY:
                continue
            after = base + i - 1
            if widths is not None:  # noqa: SIM102  a branch of its own is left out where there are none
                if (run != RIBBON) & (run != BEHIND):
                    n, m = thin(
                        pieces, k, v, (v - 1 - a) & (stride - 1), bits, run, start, way != run, hidden,
                        top, bottom, left, right, veil, work, cells, n, found, counts, m,
                    )  # fmt: skip
            if after > high:
                return n, m
            if way == RIBBON:
                m = ribbon(
                    screen, widths, opacity, nearer, after, a, end, (after - 1 - a) & (stride - 1), bits,
                    top, bottom, left, right, veil, found, counts, m,
                )  # fmt: skip
            if way != run:
                start = pieces[BEGIN + i] if v >= low else start
                run = way
            v = after
            k = i
        hold(pieces, k)
        k = np.int64(0)
        base += count


@inlined
def thin(
    pieces, k, v, lit_past, bits, run, start, closing, hidden, top, bottom, left, right, veil, work, cells, n, found,
    counts, m,
):  # fmt: skip
    """List the cells that piece number k, from vertex v − 1 to v, leaves behind, and, `closing`, the one that its run
    ends in; covers those listed so far where there are too many.

    run: 1 along x, 2 along y, negative against the axis; start: where the run begins, in the direction of travel; n:
    cells listed before; m: fragments found before. Returns how many there are then.

    Most pieces leave few cells: a vector of them is written, and what is too many written over by the next.
    """
    p = pointer(pieces)
    if p[NEAREST + k] < hidden:
        return n, m
    flat = abs(run) == 1
    low = left if flat else top
    high = right if flat else bottom
    cell = max(np.int64(p[FIRST + k]), low if run > 0 else -high)
    stop = min(np.int64(p[LAST + k]) + np.int64(closing), high if run > 0 else -low)
    sign = ONE if run > 0 else -ONE
    back = ZERO if run > 0 else ONE
    floats = half_width_pointer(work)
    integers = half_width_pointer(cells)
    steps = load(half_width_pointer(STEPS), 0)
    while cell < stop:
        if n > CELLS - LANES:
            m = fragments(work, cells, n, bits, top, bottom, left, right, veil, found, counts, m)
            n = np.int64(0)
        here = steps + np.float32(cell)
        enter = max(here, start)
        length = min(here + ONE, p[END + k]) - enter
        past = enter + HALF * length - p[BEGIN + k]
        t = min(max(past * p[PER + k], ZERO), ONE)
        store(floats, DEPTH + n, p[Q + k] + p[DEEPER + k] * t)
        store(floats, MIDDLE + n, p[ACROSS + k] + p[SLOPE + k] * past)
        store(floats, AREA + n, p[STRETCH + k] * length * (p[W + k] + t * p[WIDER + k]))
        store(floats, RISE + n, abs(p[SLOPE + k]) * length)
        store(floats, H + n, p[HEIGHT + k])
        store(floats, ALONG + n, t)
        store(floats, CELL + n, sign * here - back)
        store(integers, PLACE + n, lit_past << bits)
        store(integers, VERTEX + n, v - 1)
        store(integers, FLAT_WAY + n, -np.int64(flat))
        n += min(stop - cell, LANES)
        cell += LANES
    return n, m


@device
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
