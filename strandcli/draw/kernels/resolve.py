"""From tiles of fragments to the picture: listed by pixel, sorted by depth, laid over what is there, front to back."""

from __future__ import annotations

import numpy as np

from ...jit import inlined, inner, parallel, prange
from ...simulate.kernels.simd import get, lay, put, spread, where, width
from .tiles import BLOCK, IN_BLOCK, IN_PIXEL, LOW, PIXELS, TILE_HEIGHT, TILE_WIDTH, UNIT, depth_of, opacity_of, place_of

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
OPAQUE = np.float32(1 / 512)
"""What lies behind where less light than this gets through is left out."""
RUN = 64
"""Lists no longer than this are sorted by counting."""
FAR_OFF = np.int64(-9)


@parallel
def sizes(heads, fills, links, out):
    """Fragments in each tile: out (tiles + 1,) int64 becomes where each tile's begin among those of all."""
    workers, tiles = heads.shape
    for tile in prange(tiles):
        n = np.int64(0)
        for one in range(workers):
            if fills[one, tile] > 0:
                block = heads[one, tile]
                while block != (fills[one, tile] - 1) // BLOCK:
                    n += BLOCK
                    block = links[block]
                n += ((fills[one, tile] - 1) & IN_BLOCK) + 1
        out[tile + 1] = n
    out[0] = 0


@parallel
def resolve(
    pool, links, heads, fills, begin, most, nearest, vertices, stride, bits, tasks, kept, place, weight, along, marks
):
    """Sort each pixel's fragments by depth, ties by index, and turn opacities into weights.

    pool, links, heads, fills: as `gather` leaves them; begin (tiles + 1,) int64: places of each tile's fragments in
    what is written; most: fragments of the fullest tile; nearest: greatest number of fragments that a pixel keeps;
    vertices: of all strands, fragments with greater indices being those of solids; stride, bits: as in
    `gather.gather`; the `tasks` share the tiles.
    kept (tiles * PIXELS,) uint32: fragments of each pixel that matter, nearest first: what lies behind where less than
    `OPAQUE` gets through does not. One pixel after the other, from begin[tile] on: place (F,) uint32 the lit vertex
    before the fragment, weight (F,) float32 the share of the pixel's light that comes from it, along (F,) float32 the
    place from that lit vertex to the next. marks (V,) uint8 is set at their lit vertices.

    Pieces that follow each other in their strand and in depth add up: they are parts of one surface. All else covers a
    pixel independently.
    """
    tiles = begin.shape[0] - 1
    for one in prange(tasks):
        task = np.int64(one)
        depths = np.empty(most + RUN, np.float32)
        slots = np.empty(most, np.uint32)
        order = np.empty(most, np.uint32)
        counts = np.empty(PIXELS, np.int64)
        starts = np.empty(PIXELS, np.int64)
        for tile in range(task, tiles, tasks):
            base = tile * PIXELS
            if begin[tile + 1] == begin[tile]:
                kept[base : base + PIXELS] = 0
                continue
            share_out(pool, links, heads, fills, tile, counts, starts, depths, slots)
            rank(pool, counts, starts, depths, slots, order)
            weigh(
                pool, counts, order, nearest, vertices, stride, bits, begin[tile], base, kept, place, weight, along,
                marks,
            )  # fmt: skip


@inner
def share_out(pool, links, heads, fills, tile, counts, starts, depths, slots):
    """List a tile's fragments pixel by pixel.

    counts, starts (PIXELS,): length of each pixel's list and where it begins; depths: their depth numbers; slots: their
    places in the pool.
    """
    workers = heads.shape[0]
    counts[:] = 0
    for one in range(workers):
        block = heads[one, tile]
        end = fills[one, tile]
        while end > 0:
            final = block == (end - 1) // BLOCK
            for slot in range(np.uint64(block * BLOCK), np.uint64(end if final else block * BLOCK + BLOCK)):
                counts[np.uint64(pool[slot, 1] & IN_PIXEL)] += 1
            if final:
                break
            block = links[block]
    total = np.int64(0)
    for p in range(PIXELS):
        starts[p] = total
        total += counts[p]
    for one in range(workers):
        block = heads[one, tile]
        end = fills[one, tile]
        while end > 0:
            final = block == (end - 1) // BLOCK
            for slot in range(np.uint64(block * BLOCK), np.uint64(end if final else block * BLOCK + BLOCK)):
                p = np.uint64(pool[slot, 1] & IN_PIXEL)
                i = np.uint64(starts[p])
                starts[p] += 1
                depths[i] = depth_of(pool[slot, 0])
                slots[i] = np.uint32(slot)
            if final:
                break
            block = links[block]


@inner
def rank(pool, counts, starts, depths, slots, order):
    """Sort each pixel's list, which ends where `starts` says by now: `order` becomes its slots, nearest first, ties by
    index.

    Each goes behind as many as are nearer: counting them takes more comparisons than other ways, but none that has to
    be guessed, and vector code. Long lists are sorted in runs of `RUN` that are merged.
    """
    rows = lay(depths)
    behind = np.empty(RUN, np.float32)
    ranks = lay(behind)
    spare = np.empty(0, np.uint32)
    for p in range(PIXELS):
        n = counts[p]
        first = starts[p] - n
        for low in range(first, first + n, RUN):
            size = min(first + n - low, RUN)
            for some in range(0, size, width(rows)):
                own = get(rows, low + some)
                rank_ = spread(rows, ZERO)
                for j in range(low, low + size):
                    rank_ = where(own < rows[j], rank_ + ONE, rank_)
                put(ranks, some, rank_)
            before = np.int64(0)
            for i in range(np.uint64(size)):
                o = np.int64(behind[i])
                before += o
                order[np.uint64(low + o)] = slots[np.uint64(low) + i]
            if before != size * (size - 1) // 2:  # some are equally far, and have one place together
                insert(pool, slots, low, size, order)
        if n > RUN:
            if len(spare) < n:
                spare = np.empty(n, np.uint32)
            merge(pool, first, n, order, spare)


@inner
def insert(pool, slots, first, n, order):
    """Sort a list by whole keys, which differ: each goes before all that come before it in the list and belong
    after it."""
    for i in range(first, first + n):
        slot = slots[i]
        j = i
        while j > first and pool[order[j - 1], 0] > pool[slot, 0]:
            order[j] = order[j - 1]
            j -= 1
        order[j] = slot


@inner
def merge(pool, first, n, order, spare):
    """Sort n slots from place `first` on, runs of `RUN` of which are."""
    size = RUN
    while size < n:
        for low in range(0, n, 2 * size):
            middle = min(low + size, n)
            high = min(middle + size, n)
            i = low
            j = middle
            for o in range(low, high):
                take = i < middle and (
                    j >= high or pool[order[first + i], 0] < pool[order[first + j], 0]
                )
                spare[o] = order[first + i] if take else order[first + j]
                i += np.int64(take)
                j += np.int64(not take)
        for o in range(n):
            order[first + o] = spare[o]
        size *= 2


@inner
def weigh(
    pool, counts, order, nearest, vertices, stride, bits, o, base, kept, place, weight, along, marks
):  # fmt: skip
    """What `resolve` makes of a tile's sorted lists, written from place `o` on."""
    last = np.int64(0)
    for p in range(PIXELS):
        m = last
        last += counts[p]
        through = ONE
        front = ONE
        room = ONE
        before = FAR_OFF
        end = last
        begin = o
        most = m + nearest
        while (m < end) & (through >= OPAQUE):
            slot = np.uint64(order[np.uint64(m)])
            load = pool[slot, 1]
            identity = pool[slot, 0] & LOW
            alpha = opacity_of(load)
            t = place_of(load)
            m += 1
            if m == most:  # the last one takes in what would be behind it
                for rest in range(m, end):
                    alpha += (ONE - alpha) * opacity_of(pool[np.uint64(order[rest]), 1])
                end = m
            if abs(identity - before) > 1:
                front = through
                room = ONE
            before = identity
            alpha = min(alpha, room)
            room -= alpha
            through = front * room
            if identity < vertices:
                identity -= t >> bits
                marks[np.uint64(identity)] = 1
                marks[np.uint64(identity + stride)] = 1
            to = np.uint64(o)
            place[to] = np.uint32(identity)
            weight[to] = front * alpha
            along[to] = np.float32(t) * UNIT
            o += 1
        kept[base + p] = o - begin


@parallel
def compose(begin, kept, place, weight, along, stride, vertex, light, top, bottom, tasks, image):
    """Lay the fragments over the picture.

    begin, kept, place, weight, along, stride: as `resolve` leaves them; vertex (V, 3) radiance at lit vertices; image
    (height, width, 3), whose rows top <= y < bottom the tiles are; the `tasks` share the tiles. Where less than
    `OPAQUE` of what is behind would show it does not, and the weights make up for it.
    """
    width = image.shape[1]
    across = (width + TILE_WIDTH - 1) // TILE_WIDTH
    for one in prange(tasks):
        for tile in range(np.int64(one), begin.shape[0] - 1, tasks):
            if begin[tile + 1] > begin[tile]:
                y = top + tile // across * TILE_HEIGHT
                x = tile % across * TILE_WIDTH
                compose_tile(
                    begin[tile], tile * PIXELS, kept, place, weight, along, stride, vertex, light,
                    y, min(y + TILE_HEIGHT, bottom), x, min(x + TILE_WIDTH, width), image,
                )  # fmt: skip


@inner
def compose_tile(o, base, kept, place, weight, along, stride, vertex, light, top, bottom, left, right, image):
    """All that `compose` does in the tile that is the rows from top to before bottom, the columns from left to before
    right, whose fragments begin at place `o` and whose pixels at number `base`."""
    vertices = np.uint64(vertex.shape[0])
    for y in range(top, bottom):
        for x in range(left, right):
            n = np.int64(kept[base + (y - top) * TILE_WIDTH + x - left])
            if n == 0:
                continue
            r = ZERO
            g = ZERO
            b = ZERO
            total = ZERO
            for i in range(o, o + n):
                v = np.uint64(place[i])
                w = weight[i]
                t = along[i]
                u = v + np.uint64(stride)
                if v < vertices:
                    r += w * (vertex[v, 0] + t * (vertex[u, 0] - vertex[v, 0]))
                    g += w * (vertex[v, 1] + t * (vertex[u, 1] - vertex[v, 1]))
                    b += w * (vertex[v, 2] + t * (vertex[u, 2] - vertex[v, 2]))
                else:
                    e = v - vertices
                    r += w * light[e, 0]
                    g += w * light[e, 1]
                    b += w * light[e, 2]
                total += w
            o += n
            through = ONE - total
            if through < OPAQUE:
                scale = ONE / total
                r *= scale
                g *= scale
                b *= scale
                through = ZERO
            image[y, x, 0] = r + through * image[y, x, 0]
            image[y, x, 1] = g + through * image[y, x, 1]
            image[y, x, 2] = b + through * image[y, x, 2]
