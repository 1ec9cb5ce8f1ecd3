"""From tiles of fragments to the picture: listed by pixel, sorted by depth, laid over what is there, front to back."""

from __future__ import annotations

import numpy as np

from ...jit import inlined, inner, parallel, prange
from .tiles import BLOCK, IN_BLOCK, IN_PIXEL, LOW, PIXELS, TILE_HEIGHT, TILE_WIDTH, UNIT, opacity_of, place_of

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
OPAQUE = np.float32(1 / 512)
"""What lies behind where less light than this gets through is left out."""
STEP = 16
"""Lists begin at multiples of that in their tile's memory, so that loops over them have no rest."""
RUN = 64
"""Lists no longer than this are sorted by counting."""
LAST = np.int64(2**63 - 1)
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
        keys = np.empty(most + STEP * PIXELS, np.int64)
        loads = np.empty(most + STEP * PIXELS, np.int64)
        order = np.empty(most + STEP, np.int64)
        spare = np.empty(most + STEP, np.int64)
        counts = np.empty(PIXELS, np.int64)
        ends = np.empty(PIXELS, np.int64)
        for tile in range(task, tiles, tasks):
            base = tile * PIXELS
            if begin[tile + 1] == begin[tile]:
                kept[base : base + PIXELS] = 0
                continue
            share_out(pool, links, heads, fills, tile, counts, ends, keys, loads)
            o = begin[tile]
            for p in range(PIXELS):
                n = counts[p]
                if n > 0:
                    first = ends[p] - n
                    rank(keys, first, n, order, spare)
                    n = weigh(
                        keys, loads, first, n, order, nearest, vertices, stride, bits, o, place, weight, along, marks
                    )
                    o += n
                kept[base + p] = n


@inner
def share_out(pool, links, heads, fills, tile, counts, ends, keys, loads):
    """List a tile's fragments pixel by pixel.

    counts, ends (PIXELS,): length of each pixel's list in keys and loads, and where it ends; up to the next multiple of
    `STEP` there are keys beyond all others.
    """
    workers = heads.shape[0]
    counts[:] = 0
    for one in range(workers):
        block = heads[one, tile]
        end = fills[one, tile]
        while end > 0:
            final = block == (end - 1) // BLOCK
            for slot in range(block * BLOCK, end if final else block * BLOCK + BLOCK):
                counts[pool[slot, 1] & IN_PIXEL] += 1
            if final:
                break
            block = links[block]
    total = np.int64(0)
    for p in range(PIXELS):
        ends[p] = total
        total += (counts[p] + (STEP - 1)) // STEP * STEP
    keys[:total] = LAST
    for one in range(workers):
        block = heads[one, tile]
        end = fills[one, tile]
        while end > 0:
            final = block == (end - 1) // BLOCK
            for slot in range(block * BLOCK, end if final else block * BLOCK + BLOCK):
                load = pool[slot, 1]
                p = load & IN_PIXEL
                i = ends[p]
                ends[p] = i + 1
                keys[i] = pool[slot, 0]
                loads[i] = load
            if final:
                break
            block = links[block]


@inlined
def rank(keys, first, n, order, spare):
    """Sort the n keys from place `first` on, which differ: `order` becomes their places. Each goes behind as many as
    are smaller: counting them takes more comparisons than other ways, but none that has to be guessed, and vector code.
    Long lists are sorted in runs of `RUN` that are merged.
    """
    for low in range(0, n, RUN):
        size = min(n - low, RUN)
        begin = first + low
        whole = (size + (STEP - 1)) // STEP * STEP
        for i in range(size):
            order[low + smaller(keys, begin, whole, keys[begin + i])] = begin + i
    size = RUN
    while size < n:
        for low in range(0, n, 2 * size):
            middle = min(low + size, n)
            high = min(middle + size, n)
            i = low
            j = middle
            for o in range(low, high):
                take = i < middle and (j >= high or keys[order[i]] < keys[order[j]])
                spare[o] = order[i] if take else order[j]
                i += np.int64(take)
                j += np.int64(not take)
        for o in range(n):
            order[o] = spare[o]
        size *= 2


@inlined
def smaller(keys, begin, n, key):
    """How many of n keys are smaller than one."""
    count = np.int64(0)
    for j in range(np.uint64(begin), np.uint64(begin + n)):
        count += np.int64(keys[j] < key)
    return count


@inlined
def weigh(keys, loads, first, n, order, nearest, vertices, stride, bits, o, place, weight, along, marks):
    """All that `resolve` does with one sorted list, written from place `o` on; returns how many are kept."""
    through = ONE
    front = ONE
    room = ONE
    before = FAR_OFF
    m = np.int64(0)
    while (m < n) & (through >= OPAQUE):
        i = order[m]
        identity = keys[i] & LOW
        alpha = opacity_of(loads[i])
        t = place_of(loads[i])
        m += 1
        if m == nearest:  # the last one takes in what would be behind it
            for rest in range(m, n):
                alpha += (ONE - alpha) * opacity_of(loads[order[rest]])
            n = m
        if abs(identity - before) > 1:
            front = through
            room = ONE
        before = identity
        alpha = min(alpha, room)
        room -= alpha
        through = front * room
        if identity < vertices:
            identity -= t >> bits
            marks[identity] = 1
            marks[identity + stride] = 1
        place[o] = np.uint32(identity)
        weight[o] = front * alpha
        along[o] = np.float32(t) * UNIT
        o += 1
    return m


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
