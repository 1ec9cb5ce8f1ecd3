"""From a tile's sorted fragments to the share of its pixel that each shows."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ...common.kernels.bits import popcount
from .masks import EMPTY, POINTS, WHOLE, covered
from .tiles import NUMBERS, PIXEL_BITS, PIXELS, TILE_WIDTH, UNIT

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
OPAQUE = np.float32(1 / 512)
"""What lies behind where less light than this gets through is left out."""
MASKED = np.float32(0.5)
"""Samples. Of strands that are wider it may be asked which points of a sample they show."""
FAR_OFF = np.int64(-9)
TWO, FOUR = np.uint64(2), np.uint64(NUMBERS)


@inlined
def numbers(fragments, i):
    """Of fragment number i its opacity, its vertex, and its place on the way from a lit vertex to the next."""
    which = np.uint64(i) * FOUR
    alpha = np.int32(fragments[which + np.uint64(1)]).view(np.float32)
    vertex = np.int64(np.uint32(fragments[which + TWO]))
    return alpha, vertex, np.int64(np.uint32(fragments[which + np.uint64(3)]) >> PIXEL_BITS)


@device
def composite(fragments, counts, order, vertices, tile, o, out, marks):
    """Weights of the sorted fragments of tile number `tile`, written into `out`, `tiles.Fragments`, from place `o` on;
    returns where they end.

    fragments, counts, order: as `sorting.sort_pixels` leaves them; vertices: of all strands; marks (V,): set at
    the lit vertices before fragments that matter.
    """
    base = tile * PIXELS
    bits = out.place_bits
    end = np.int64(0)
    for p in range(np.uint64(PIXELS)):
        m = end
        end += counts[p]
        begin = o
        through = ONE
        front = ONE
        room = ONE
        previous = FAR_OFF
        while (m < end) & (through >= OPAQUE):
            alpha, identity, t = numbers(fragments, order[np.uint64(m)])
            m += 1
            if abs(identity - previous) > 1:
                front = through
                room = ONE
            previous = identity
            alpha = min(alpha, room)
            room -= alpha
            through = front * room
            if identity < vertices:
                identity -= t >> bits
                marks[np.uint64(identity)] = 1
            to = np.uint64(o)
            out.place[to] = np.uint32(identity)
            out.weight[to] = front * alpha
            out.along[to] = np.float32(t) * UNIT
            o += 1
        out.kept[np.uint64(base) + p] = o - begin
    return o


@device
def composite_masked(fragments, counts, order, lines, table, tile, o, out, marks):
    """What `composite` does, where it is known which points of a sample wide strands cover: what is in front hides just
    these. What is thin covers a sample independently.

    lines: `ScreenLines` with widths in samples; table: of `strandcli.draw.coverage.masks.sides`; tile: `tiles.Tile`;
    the rest as in `composite`.
    """
    screen, widths = lines.screen, lines.widths
    base, bits = tile.number * PIXELS, out.place_bits
    end = np.int64(0)
    vertices = screen.shape[0]
    for p in range(np.uint64(PIXELS)):
        m = end
        end += counts[p]
        begin = o
        x = np.float32(tile.left + np.int64(p) % TILE_WIDTH) + HALF
        y = np.float32(tile.top + np.int64(p) // TILE_WIDTH) + HALF
        thin = front = room = ONE
        free = WHOLE
        total = ZERO
        previous = FAR_OFF
        while m < end:
            alpha, identity, t = numbers(fragments, order[np.uint64(m)])
            m += 1
            mine = EMPTY
            if identity < vertices and widths[identity] > MASKED:  # beyond vertices it is of a solid's edge
                mine = covered(table, screen, widths, identity, x, y)
            if mine != EMPTY:
                shown = mine & free
                share = alpha * thin * np.float32(popcount(shown)) / np.float32(popcount(mine))
                free &= ~mine
            else:
                shown = free
                if abs(identity - previous) > 1:
                    front, room = thin, ONE
                previous = identity
                alpha = min(alpha, room)
                room -= alpha
                share = front * alpha * np.float32(popcount(free)) / np.float32(POINTS)
                thin = front * room
            share = min(share, ONE - total)  # areas are exact, what hides of them is counted in points
            if share > ZERO:
                if identity < vertices:
                    identity -= t >> bits
                    marks[np.uint64(identity)] = 1
                to = np.uint64(o)
                out.place[to] = np.uint32(identity)
                out.weight[to] = share
                out.along[to] = np.float32(t) * UNIT
                out.seen[to] = shown
                total += share
                o += 1
            if thin * np.float32(popcount(free)) < OPAQUE * np.float32(POINTS):
                break
        if (free == EMPTY) & ((o > begin + 1) | (m < end)):  # between strands that cover all nothing shows through
            for i in range(begin, o):
                out.weight[i] /= total
        out.kept[np.uint64(base) + p] = o - begin
    return o
