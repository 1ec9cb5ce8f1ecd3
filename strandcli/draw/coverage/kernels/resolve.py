"""From the segments of strands in each tile to the picture: fragments found, sorted by depth and composited."""

from __future__ import annotations

import numpy as np

from ....jit import device, parallel, prange
from ....simd import broadcast, load, pointer, prefetch, store, triple_pointer
from . import cells, segments
from .composite import OPAQUE, composite, composite_masked
from .fragments import Strands, find_fragments
from .sorting import RUN, list_by_pixel, sort_pixels
from .tiles import NUMBERS, PIXELS, TILE_WIDTH, tile_at

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
FEW = np.int64(16384)
"""Fragments of a tile that there is room for to begin with."""
AHEAD = np.uint64(24)
"""Fragments that the light is asked for before it is needed."""
NONE, TWO, THREE = np.uint64(0), np.uint64(2), np.uint64(3)


@parallel
def resolve(lines, opacity, depth_slope, solids, segments_, table, tasks, out, found, marks):
    """Find each pixel's fragments, sort them by depth, ties by index, and turn opacities into weights.

    lines: `ScreenLines`; opacity: of the material; depth_slope: `DepthSlope`; solids: `SolidPixels`; segments_:
    `TileSegments` of the rows that `out`, `Fragments`, is for; table: of `strandcli.draw.coverage.masks.sides`, or
    None: no fragment's points are asked for. The `tasks` share the tiles and the memory evenly. found (tiles,) int64:
    fragments that matter or not, negative where there was no room; marks (V,) uint8: set at the lit vertices before
    fragments that matter.

    Segments that follow each other in their strand and in depth add up: they are parts of one surface. All else covers
    a pixel independently, or, with a table, by points (`composite.composite_masked`).
    """
    share = np.int64(out.place.shape[0] // tasks)
    for one in prange(tasks):
        task = np.int64(one)
        room = np.int64(min(FEW, share))
        fragments = np.empty(room * NUMBERS, np.int32)
        counts, starts = np.empty(PIXELS, np.int32), np.empty(PIXELS, np.int32)
        depths, nearer = np.empty(0, np.float32), np.empty(RUN, np.float32)
        order, ranked, spare = np.empty(0, np.uint32), np.empty(0, np.uint32), np.empty(0, np.uint32)
        occlusion = np.zeros(PIXELS, np.float32)
        strands = Strands(lines.first, lines.screen, lines.widths, opacity, depth_slope, out.stride)
        work = cells.Work(
            np.empty(segments.ROWS * segments.ROW, np.float32), np.empty(cells.ROWS * cells.CELLS, np.float32),
            np.empty(cells.INTEGERS * cells.CELLS, np.int32),
        )  # fmt: skip
        o = task * share
        end = o + share
        for number in range(task, out.begin.shape[0], tasks):
            tile = tile_at(number, out)
            while True:  # in one place, for it is the greater part of what is compiled
                target = cells.Target(
                    tile.top, tile.bottom, tile.left, tile.right, out.place_bits, occlusion, fragments, counts
                )
                n = find_fragments(strands, solids, segments_, number, out.width, work, target, marks)
                if n <= room or n > end - o:
                    break
                room = min(n + n // 4, share)
                fragments = np.empty(room * NUMBERS, np.int32)
            found[number] = n if n <= end - o else -n
            if n == 0 or n > end - o:
                leave_empty(out, number)
                continue
            if depths.shape[0] < room + RUN:
                depths, order = np.empty(room + RUN, np.float32), np.empty(room + RUN, np.uint32)
                ranked, spare = np.empty(room + RUN, np.uint32), np.empty(room, np.uint32)
            begin_tile(out, number, o)
            list_by_pixel(fragments, n, counts, starts, depths, order)
            sort_pixels(fragments, counts, starts, depths, order, nearer, spare, ranked)
            if table is None:
                o = composite(fragments, counts, ranked, lines.screen.shape[0], number, o, out, marks)
            else:
                o = composite_masked(fragments, counts, ranked, lines, table, tile, o, out, marks)


# Numba takes what a kernel itself writes through a member of a tuple for dead code, and leaves it out.


@device
def leave_empty(out, number):
    """Note that a tile has no fragments."""
    out.begin[number] = -1
    out.kept[number * PIXELS : (number + 1) * PIXELS] = 0


@device
def begin_tile(out, number, o):
    """Note where a tile's fragments begin."""
    out.begin[number] = o


@parallel
def compose(fragments, vertex, light, tasks, image):
    """Lay the fragments over the picture.

    fragments: `Fragments`; vertex (V, 3) radiance at lit vertices; light (E, 3) radiance of solids at their edges;
    image (height, width, 3); the `tasks` share the tiles. Where less than `OPAQUE` of what is behind would show it does
    not, and the weights make up for it.
    """
    for one in prange(tasks):
        for number in range(np.int64(one), fragments.begin.shape[0], tasks):
            if fragments.begin[number] >= 0:
                compose_tile(fragments, tile_at(number, fragments), vertex, light, image)


@device
def compose_tile(fragments, tile, vertex, light, image):
    """All that `compose` does in a tile."""
    vertices = np.uint64(vertex.shape[0])
    colours = triple_pointer(vertex)
    edges = triple_pointer(light)
    picture = triple_pointer(image)
    width = image.shape[1]
    at = np.uint64(fragments.begin[tile.number])
    base = tile.number * PIXELS
    place = fragments.place
    last = np.uint64(place.shape[0] - 1)
    step = THREE * np.uint64(fragments.stride)
    for y in range(tile.top, tile.bottom):
        for x in range(tile.left, tile.right):
            n = np.uint64(fragments.kept[np.uint64(base + (y - tile.top) * TILE_WIDTH + x - tile.left)])
            if n == NONE:
                continue
            shown = broadcast(colours, ZERO)
            total = ZERO
            for i in range(at, at + n):
                v = np.uint64(place[i])
                w = fragments.weight[i]
                later = THREE * np.uint64(place[min(i + AHEAD, last)])
                prefetch(pointer(vertex), later)
                prefetch(pointer(vertex), later + step + TWO)
                if v < vertices:
                    # of the light at both lit vertices
                    far = w * fragments.along[i]
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
