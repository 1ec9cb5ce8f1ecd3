"""Resolving sorted strands: fragments of a tile are found, sorted by depth and composited, and later given colours."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined, parallel, prange
from ....simd import broadcast, load, pointer, prefetch, store, triple_pointer
from ...common.kernels.numbers import ONE, TWO, ZERO
from . import cells, ribbon, segments
from .crowds import CROWDED, ROUNDED, list_by_pixel, list_rows, order_rows
from .fragments import Strands, find_fragments
from .sorting import RUN, sort_pixels
from .tiles import (
    AT_OPACITY,
    AT_PLACE,
    AT_VERTEX,
    NUMBERS,
    PIXEL_BITS,
    PIXELS,
    ROW_BITS,
    STEP,
    TILE_WIDTH,
    UNIT,
    WINDOWS,
    tile_at,
)

INITIAL_ROOM = np.int64(49152)
"""Initial capacity for the fragments of a tile."""
AHEAD = np.uint64(24)
"""Fragments that light is prefetched ahead of its use."""
NONE, SECOND, THREE = np.uint64(0), np.uint64(2), np.uint64(3)


@parallel
def resolve(lines, opacity, depth_slope, solids, segments_, tasks, out, found, marks):
    """Find the fragments of each pixel, sort them by depth, ties by vertex, and compute their weights.

    lines: `ScreenLines`; opacity: of the material; depth_slope: `DepthSlope`; solids: `SolidPixels`; segments_:
    `TileSegments` of the rows of `out`; tasks: number of tasks, which share the tiles and the memory evenly; out:
    `Fragments`, written; found (tiles,) int64, written: number of all fragments, visible or not, negative if there was
    no room; marks (V,) uint8: set at the vertices that visible fragments take light from.
    """
    share = np.int64(out.vertex.shape[0] // tasks)
    for one in prange(tasks):
        task = np.int64(one)
        room = np.int64(max(min(INITIAL_ROOM, share), RUN))
        fragments, listed = np.empty(room * NUMBERS, np.int32), np.empty(room * NUMBERS, np.int32)
        counts, ends = np.empty(PIXELS, np.int32), np.empty(PIXELS, np.int32)
        depths, ranks = np.empty(room + RUN, np.float32), np.empty(RUN, np.float32)
        slots, ordered, row_depths = np.empty(0, np.int32), np.empty(0, np.int32), np.empty(0, np.float32)
        occlusion, hidden = np.zeros(PIXELS, np.float32), np.empty(WINDOWS, np.float32)
        through, least, widest = np.empty(PIXELS, np.float32), np.empty(PIXELS, np.float32), np.empty(1, np.float32)
        strands = Strands(lines.first, lines.screen, lines.widths, opacity, depth_slope, out.stride)
        work = cells.Work(
            np.empty(segments.ROWS * segments.ROW, np.float32), np.empty(cells.ROWS * cells.CELLS, np.float32),
            np.empty(cells.INTEGERS * cells.CELLS, np.int32), np.empty(ribbon.ROWS * ribbon.ROW, np.float32),
        )  # fmt: skip
        o, end = task * share, (task + 1) * share
        for number in range(task, out.begin.shape[0], tasks):
            tile = tile_at(number, out)
            rows = list_rows(segments_, number, slots)
            if slots.shape[0] < rows:
                size = rows + rows // 4
                slots, ordered, row_depths = (
                    np.empty(size, np.int32),
                    np.empty(size, np.int32),
                    np.empty(size, np.float32),
                )
                list_rows(segments_, number, slots)
            if rows >= CROWDED:
                order_rows(segments_.depths, ordered[:rows], slots, row_depths, ends)
                slots, ordered = ordered, slots
            while True:  # one call of find_fragments, which is the greater part of what is compiled
                target = cells.Target(
                    tile.top, tile.bottom, tile.left, tile.right, out.place_bits, occlusion, fragments, counts,
                    OPAQUE * ROUNDED, through, least, ends, hidden, widest,
                )  # fmt: skip
                n = find_fragments(strands, solids, segments_.pool, slots[:rows], out.width, work, target, marks)
                if n <= room or n > end - o:
                    break
                room = min(n + n // 4, share)
                fragments, listed = np.empty(room * NUMBERS, np.int32), np.empty(room * NUMBERS, np.int32)
                depths = np.empty(room + RUN, np.float32)
            found[number] = n if n <= end - o else -n
            if n == 0 or n > end - o:
                set_begin(out, number, -1, ZERO)
                continue
            set_begin(out, number, o, widest[0])
            list_by_pixel(fragments, n, counts, ends, depths, listed)
            # their memory serves for what sorts them
            order, spare = fragments[: room + RUN].view(np.uint32), fragments[room + RUN :].view(np.uint32)
            sort_pixels(listed, counts, ends, depths, ranks, spare, order)
            o = composite(listed, counts, ends, order, lines.screen.shape[0], tile, o, out, marks)


@device
def set_begin(out, number, o, widest):
    """Store the index of a tile's first fragment, −1 for none, and the width of its widest segment. A function of its
    own, because Numba drops direct writes of a parallel loop to a member of a tuple as dead code."""
    out.begin[number] = o
    out.widest[number] = widest
    if o < 0:
        out.counts[number * PIXELS : (number + 1) * PIXELS] = 0


@parallel
def blend(fragments, radiance, light, tasks, image):
    """Blend the fragments with the picture behind them.

    fragments: `Fragments`; radiance (V, 3): at lit vertices; light (E, 3): radiance of solids at their edge pixels;
    tasks: number of tasks, which share the tiles; image (height, width, 3): changed. If less than `OPAQUE` of the
    background would show, it is left out, and the weights are scaled to 1.
    """
    for one in prange(tasks):
        for number in range(np.int64(one), fragments.begin.shape[0], tasks):
            if fragments.begin[number] >= 0:
                blend_tile(fragments, tile_at(number, fragments), radiance, light, image)


@device
def blend_tile(fragments, tile, radiance, light, image):
    """Blend the fragments of a tile; arguments as in `blend`."""
    vertices = np.uint64(radiance.shape[0])
    colours = triple_pointer(radiance)
    edges = triple_pointer(light)
    picture = triple_pointer(image)
    width = image.shape[1]
    at = np.uint64(fragments.begin[tile.number])
    base = tile.number * PIXELS
    vertex = fragments.vertex
    last = np.uint64(vertex.shape[0] - 1)
    step = THREE * np.uint64(fragments.stride)
    for y in range(tile.top, tile.bottom):
        for x in range(tile.left, tile.right):
            n = np.uint64(fragments.counts[np.uint64(base + (y - tile.top) * TILE_WIDTH + x - tile.left)])
            if n == NONE:
                continue
            colour = broadcast(colours, ZERO)
            total = ZERO
            for i in range(at, at + n):
                v = np.uint64(vertex[i])
                w, along = fragments.weight[i], fragments.along[i]
                later = THREE * np.uint64(vertex[min(i + AHEAD, last)])
                prefetch(pointer(radiance), later)
                prefetch(pointer(radiance), later + step + SECOND)
                if v < vertices:
                    # weights of the lit vertices after and before the fragment
                    far = w * max(along, ZERO)
                    near = w - far
                    after = v * THREE + (step if along >= ZERO else NONE)
                    colour += near * load(colours, THREE * v) + far * load(colours, after)
                else:
                    colour += w * load(edges, THREE * (v - vertices))
                total += w
            at += n
            through = ONE - total
            if through < OPAQUE:
                colour *= ONE / total
                through = ZERO
            here = np.uint64(3 * (y * width + x))
            store(picture, here, colour + through * load(picture, here))


OPAQUE = np.float32(1 / 512)
"""Transmittance below which everything behind is left out."""
OPEN, CLOSED, SOLID = np.uint8(0), np.uint8(1), np.uint8(2)
"""Bits of `Fragments.closed`."""
NO_VERTEX = np.int64(-9)
"""A vertex next to none."""
FOUR = np.uint64(NUMBERS)
BETWEEN = np.int64((1 << STEP) - 1)
"""Bits of a position that tell how far it is from a lit vertex to the next."""


@device
def composite(fragments, counts, ends, order, vertices, tile, o, out, marks):
    """Write the visible fragments of a tile, with their weights, to `out` from index o on; return the index of their
    end.

    fragments, counts, ends, order: from `sorting.sort_pixels`; vertices: number of vertices of all strands; tile:
    `tiles.Tile`; out: `tiles.Fragments`; marks (V,): set at the vertices that they take light from.

    Segments that follow each other in their strand and in depth are parts of one surface: their opacities add up. The
    rest cover the pixel independently. A fragment before which less than `tiles.Fragments.slight` is let through
    takes the light of that end of its part of the strand whose rank among lit vertices is even, so that fewer vertices
    are lit; this depends on its pixel alone, so that neither layers nor a crop window change one.
    """
    base = tile.number * PIXELS
    bits = out.place_bits
    for p in range(np.uint64(PIXELS)):
        end = np.int64(ends[p])
        m = end - np.int64(counts[p])
        begin = o
        through = ONE
        front = ONE
        room = ONE
        previous = NO_VERTEX
        total = ZERO
        solid = False
        while (m < end) & (through >= OPAQUE):
            at = np.uint64(order[np.uint64(m)]) * FOUR
            alpha = np.int32(fragments[at + AT_OPACITY]).view(np.float32)
            identity = np.int64(np.uint32(fragments[at + AT_VERTEX]))
            t = np.int64(np.uint32(fragments[at + AT_PLACE]) >> PIXEL_BITS)
            m += 1
            if abs(identity - previous) > 1:
                front = through
                room = ONE
            previous = identity
            alpha = min(alpha, room)
            room -= alpha
            through = front * room
            share = front * alpha
            along = np.float32(t & BETWEEN) * UNIT
            solid |= identity >= vertices
            if identity < vertices:
                identity -= (t >> bits) & (out.stride - 1)
                odd = t >> STEP
                if front < out.slight:
                    identity += odd * out.stride
                    along = -TWO - (along - np.float32(odd))
                else:
                    marks[np.uint64(identity + out.stride)] = 1
                marks[np.uint64(identity)] = 1
            to = np.uint64(o)
            out.vertex[to] = np.uint32(identity)
            out.weight[to] = share
            total += share
            out.along[to] = along
            o += 1
        out.counts[np.uint64(base) + p] = o - begin
        if o > begin:
            close(out, tile, np.int64(p), total, solid)
    return o


@inlined
def close(out, tile, p, total, solid):
    """Store whether the fragments of pixel p of a tile let nothing through, as `resolve.blend` has it; total: of their
    weights, from the first to the last; solid: whether one of them is a solid's."""
    at = (tile.top + (p >> ROW_BITS)) * out.width + tile.left + (p & (TILE_WIDTH - 1))
    closed = CLOSED | SOLID if solid else CLOSED
    out.closed[np.uint64(at)] = closed if ONE - total < OPAQUE else OPEN
