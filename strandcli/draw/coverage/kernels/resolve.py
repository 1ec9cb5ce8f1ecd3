"""From parts of strands to the picture: fragments found, listed by pixel, sorted by depth, laid over what is there."""

from __future__ import annotations

import numpy as np

from ....constants import VECTOR
from ....jit import device, inlined, parallel, prange
from ....simd import broadcast, count_true, half_width_pointer, lane_count, load, pointer, store, triple_pointer, where
from ...common.kernels.prefetch import prefetch
from . import segments
from .composite import OPAQUE, weigh, weigh_points
from .coverage import CELLS, INTEGERS, ROWS
from .fragments import gather
from .tiles import NUMBERS, PIXELS, TILE_HEIGHT, TILE_WIDTH, corner

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
RUN = 128
"""Lists no longer than this are sorted by counting."""
FEW_LANES = VECTOR // 2 // 4
"""Fragments that are a vector of `strip`, which most lists are,"""
MORE_LANES = VECTOR // 4
"""or one of `lay`."""
STEPS = np.arange(MORE_LANES, dtype=np.float32)
FEW = np.int64(16384)
"""Fragments of a tile that there is room for to begin with."""
AHEAD = np.uint64(24)
"""Fragments that the light is asked for before it is needed."""
IN_PIXEL = np.int32(PIXELS - 1)
ALL = np.uint64(0xFFFFFFFFFFFFFFFF)
NONE, ONE_ON, TWO, THREE, FOUR = np.uint64(0), np.uint64(1), np.uint64(2), np.uint64(3), np.uint64(NUMBERS)


@parallel
def resolve(
    first, screen, widths, opacity, nearer, stride, bits, hides, edges, depth, cover, pool, links, heads, fills,
    nearest, table, top, bottom, width, tasks, begin, kept, found, place, weight, along, seen, marks,
):  # fmt: skip
    """Find each pixel's fragments, sort them by depth, ties by index, and turn opacities into weights.

    first … cover: as in `gather.gather`; pool, links, heads, fills: as `parts.share_out` leaves them for the rows
    top <= y < bottom of a picture of this width; nearest: greatest number of fragments that a pixel keeps. The `tasks`
    share the tiles and the memory evenly.
    begin (tiles,) int64: where each tile's fragments begin, −1 where it has none; kept (tiles * PIXELS,) uint32:
    fragments of each pixel that matter, nearest first: what lies behind where less than `OPAQUE` gets through does not.
    One pixel after the other: place (F,) uint32 the lit vertex before the fragment, or V + e, weight (F,) float32 the
    share of the pixel's light that comes from it, along (F,) float32 the place from that lit vertex to the next; seen
    (F,) uint64 the points of its sample that it shows, by the table of `strandcli.draw.coverage.masks.sides`,
    or both None.
    marks (V,) uint8 is set at the lit vertices before them. found (tiles,) int64: fragments that matter or not,
    negative where there was no room.

    Pieces that follow each other in their strand and in depth add up: they are parts of one surface. All else covers a
    pixel independently, or, with a table, by points (`weigh.weigh_points`).
    """
    tiles = begin.shape[0]
    share = np.int64(place.shape[0] // tasks)
    for one in prange(tasks):
        task = np.int64(one)
        room = np.int64(min(FEW, share))
        fragments = np.empty(room * NUMBERS, np.int32)
        depths = np.empty(room + RUN, np.float32)
        order = np.empty(room + RUN, np.uint32)
        sorted_ = np.empty(room + RUN, np.uint32)
        spare = np.empty(room, np.uint32)
        counts = np.empty(PIXELS, np.int32)
        starts = np.empty(PIXELS, np.int32)
        strand = np.empty(segments.ROWS * segments.ROW, np.float32)
        work = np.empty(ROWS * CELLS, np.float32)
        cells = np.empty(INTEGERS * CELLS, np.int32)
        veil = np.zeros(PIXELS, np.float32)
        behind = np.empty(RUN, np.float32)
        o = task * share
        end = o + share
        for tile in range(task, tiles, tasks):
            base = tile * PIXELS
            y, x = corner(tile, width, top)
            below = min(y + TILE_HEIGHT, bottom)
            right = min(x + TILE_WIDTH, width)
            while True:  # in one place, for it is the greater part of what is compiled
                n = gather(
                    first, screen, widths, opacity, nearer, stride, bits, hides, edges, depth, cover, pool, links,
                    heads, fills, tile, y, below, x, right, width, strand, work, cells, veil, fragments, counts, marks,
                )  # fmt: skip
                if n <= room or n > end - o:
                    break
                room = min(n + n // 4, share)
                fragments = np.empty(room * NUMBERS, np.int32)
                depths = np.empty(room + RUN, np.float32)
                order = np.empty(room + RUN, np.uint32)
                sorted_ = np.empty(room + RUN, np.uint32)
                spare = np.empty(room, np.uint32)
            begin[tile] = -1
            found[tile] = n if n <= end - o else -n
            if n == 0 or n > end - o:
                kept[base : base + PIXELS] = 0
                continue
            begin[tile] = o
            share_out(fragments, n, counts, starts, depths, order)
            rank(fragments, counts, starts, depths, order, behind, spare, sorted_)
            if table is None:
                o = weigh(
                    fragments, counts, sorted_, nearest, screen.shape[0], bits, o, base, kept, place, weight, along,
                    marks,
                )  # fmt: skip
            else:
                o = weigh_points(
                    fragments, counts, sorted_, screen, widths, table, bits, x, y, o, base, kept, place, weight, along,
                    seen, marks,
                )  # fmt: skip


@device
def share_out(fragments, n, counts, starts, depths, listed):
    """List a tile's n fragments pixel by pixel.

    counts, starts (PIXELS,): length of each pixel's list and, afterwards, where it ends; depths: their depth numbers;
    listed: which they are.
    """
    total = np.int64(0)
    for p in range(PIXELS):
        starts[p] = total
        total += counts[p]
    for i in range(np.uint64(n)):
        p = np.uint64(fragments[i * FOUR + np.uint64(3)] & IN_PIXEL)
        at = np.uint64(starts[p])
        starts[p] += 1
        depths[at] = np.int32(fragments[i * FOUR]).view(np.float32)
        listed[at] = np.uint32(i)


@device
def rank(fragments, counts, ends, depths, listed, behind, spare, order):
    """Sort each pixel's list, nearest first, ties by index: `order` becomes what `listed` is before;
    behind (RUN,) float32, spare: to work with.

    Each goes behind as many as are nearer: counting them takes more comparisons than other ways, but none that has to
    be guessed, and vector code. Long lists are sorted in runs of `RUN` that are merged.
    """
    for p in range(counts.shape[0]):
        n = np.int64(counts[p])
        first = np.int64(ends[p]) - n
        if n <= FEW_LANES:
            if tied(half_width_pointer(depths), load(half_width_pointer(STEPS), 0), first, n, FEW_LANES, listed, order):
                insert(fragments, listed, first, n, order)
            continue
        if n <= MORE_LANES:
            if tied(pointer(depths), load(pointer(STEPS), 0), first, n, MORE_LANES, listed, order):
                insert(fragments, listed, first, n, order)
            continue
        for low in range(first, first + n, RUN):
            size = min(first + n - low, RUN)
            count_nearer(pointer(depths), pointer(behind), low, size)
            total = np.int64(0)
            for i in range(np.uint64(size)):
                o = np.int64(behind[i])
                total += o
                order[np.uint64(low + o)] = listed[np.uint64(low) + i]
            if total != size * (size - 1) // 2:  # some are equally far, and have one place together
                insert(fragments, listed, low, size, order)
        if n > RUN:
            merge(fragments, first, n, order, spare)


@inlined
def tied(rows, steps, low, n, lanes, listed, order):
    """Sort n that are no more than a vector from place `low` on, and tell whether some are equally far. As many steps
    for a few as for all: when a short loop ends has to be guessed. What is no part of the list goes behind it, where
    the next one comes."""
    own = load(rows, low)
    there = steps < np.float32(n)
    taken = np.uint64(0)
    for i in range(lanes):
        o = count_true((own > rows[low + i]) & there) if i < n else np.uint64(lanes)
        order[np.uint64(low) + o] = listed[np.uint64(low + i)]
        taken |= ONE_ON << o
    return taken & ~(ALL << np.uint64(n)) != ~(ALL << np.uint64(n))


@inlined
def count_nearer(rows, ranks, low, size):
    """How many of so many depths from place `low` on are nearer than each."""
    for some in range(0, size, lane_count(rows)):
        own = load(rows, low + some)
        nearer = broadcast(rows, ZERO)
        for j in range(low, low + size):
            nearer = where(own < rows[j], nearer + ONE, nearer)
        store(ranks, some, nearer)


@device
def before(fragments, i, j):
    """Whether a fragment comes before another."""
    one = np.int32(fragments[np.uint64(i) * FOUR]).view(np.float32)
    other = np.int32(fragments[np.uint64(j) * FOUR]).view(np.float32)
    tie = fragments[np.uint64(i) * FOUR + TWO] < fragments[np.uint64(j) * FOUR + TWO]
    return (one > other) | ((one == other) & tie)


@device
def insert(fragments, listed, first, n, order):
    """Sort a list of n from place `first` on, one after the other."""
    for i in range(first, first + n):
        new = listed[i]
        j = i
        while j > first and before(fragments, new, order[j - 1]):
            order[j] = order[j - 1]
            j -= 1
        order[j] = new


@device
def merge(fragments, first, n, order, spare):
    """Sort a list of n from place `first` on, runs of `RUN` of which are."""
    size = RUN
    while size < n:
        for low in range(first, first + n, 2 * size):
            middle = min(low + size, first + n)
            high = min(middle + size, first + n)
            i = low
            j = middle
            for o in range(low, high):
                take = i < middle and (j >= high or before(fragments, order[i], order[j]))
                spare[o - first] = order[i] if take else order[j]
                i += np.int64(take)
                j += np.int64(not take)
        for o in range(n):
            order[first + o] = spare[o]
        size *= 2


@parallel
def compose(begin, kept, place, weight, along, stride, vertex, light, top, bottom, tasks, image):
    """Lay the fragments over the picture.

    begin, kept, place, weight, along, stride: as `resolve` leaves them; vertex (V, 3) radiance at lit vertices; image
    (height, width, 3), whose rows top <= y < bottom the tiles are; the `tasks` share the tiles. Where less than
    `OPAQUE` of what is behind would show it does not, and the weights make up for it.
    """
    width = image.shape[1]
    for one in prange(tasks):
        for tile in range(np.int64(one), begin.shape[0], tasks):
            if begin[tile] >= 0:
                y, x = corner(tile, width, top)
                compose_tile(
                    begin[tile], tile * PIXELS, kept, place, weight, along, stride, vertex, light,
                    y, min(y + TILE_HEIGHT, bottom), x, min(x + TILE_WIDTH, width), image,
                )  # fmt: skip


@device
def compose_tile(o, base, kept, place, weight, along, stride, vertex, light, top, bottom, left, right, image):
    """All that `compose` does in the tile that is the rows from top to before bottom, the columns from left to before
    right, whose fragments begin at place `o` and whose pixels at number `base`."""
    vertices = np.uint64(vertex.shape[0])
    colours = triple_pointer(vertex)
    edges = triple_pointer(light)
    picture = triple_pointer(image)
    width = image.shape[1]
    at = np.uint64(o)
    last = np.uint64(place.shape[0] - 1)
    step = THREE * np.uint64(stride)
    for y in range(top, bottom):
        for x in range(left, right):
            n = np.uint64(kept[np.uint64(base + (y - top) * TILE_WIDTH + x - left)])
            if n == NONE:
                continue
            shown = broadcast(colours, ZERO)
            total = ZERO
            for i in range(at, at + n):
                v = np.uint64(place[i])
                w = weight[i]
                later = THREE * np.uint64(place[min(i + AHEAD, last)])
                prefetch(vertex, later)
                prefetch(vertex, later + step + TWO)
                if v < vertices:
                    # of the light at both lit vertices
                    far = w * along[i]
                    near = w - far
                    shown += near * load(colours, THREE * v) + far * load(colours, THREE * v + step)
                else:
                    shown += w * load(edges, THREE * (v - vertices))
                total += w
            at += n
            through = ONE - total
            if through < OPAQUE:
                shown *= ONE / total
                through = ZERO
            here = np.uint64(3 * (y * width + x))
            store(picture, here, shown + through * load(picture, here))
