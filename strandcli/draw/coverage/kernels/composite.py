"""Weights of a tile's sorted fragments: the share of its pixel that each contributes."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ...common.kernels.numbers import ONE, ZERO
from .tiles import AT_OPACITY, AT_PLACE, AT_VERTEX, NUMBERS, PIXEL_BITS, PIXELS, ROW_BITS, STEP, TILE_WIDTH, UNIT, alone

OPAQUE = np.float32(1 / 512)
"""Transmittance below which everything behind is left out."""
OPEN, CLOSED, SOLID = np.uint8(0), np.uint8(1), np.uint8(2)
"""Bits of `Fragments.closed`."""
NO_VERTEX = np.int64(-9)
"""A vertex next to none."""
FOUR = np.uint64(NUMBERS)
BETWEEN = np.int64((1 << STEP) - 1)
"""Bits of a position that tell how far it is from a lit vertex to the next."""


@inlined
def numbers(fragments, i):
    """Return opacity, vertex and fixed-point position of fragment number i."""
    first = np.uint64(i) * FOUR
    alpha = np.int32(fragments[first + AT_OPACITY]).view(np.float32)
    vertex = np.int64(np.uint32(fragments[first + AT_VERTEX]))
    return alpha, vertex, np.int64(np.uint32(fragments[first + AT_PLACE]) >> PIXEL_BITS)


@device
def composite(fragments, counts, ends, order, vertices, tile, o, out, marks):
    """Write the visible fragments of a tile, with their weights, to `out` from index o on; return the index of their
    end.

    fragments, counts, ends, order: from `sorting.sort_pixels`; vertices: number of vertices of all strands; tile:
    `tiles.Tile`; out: `tiles.Fragments`; marks (V,): set at the vertices that they take light from.

    Segments that follow each other in their strand and in depth are parts of one surface: their opacities add up. All
    others cover the pixel independently. A fragment before which less than `tiles.Fragments.slight` is let through
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
            alpha, identity, t = numbers(fragments, order[np.uint64(m)])
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
                    along = alone(along - np.float32(odd))
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
