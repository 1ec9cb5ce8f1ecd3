"""Weights of a tile's sorted fragments: the share of its pixel that each contributes."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ...common.kernels.bits import popcount
from .masks import ALL_POINTS, NO_POINTS, POINTS, covered_points
from .segments import is_ribbon
from .tiles import AT_OPACITY, AT_PLACE, AT_VERTEX, NUMBERS, PIXEL_BITS, PIXELS, ROW_BITS, STEP, TILE_WIDTH, UNIT, alone

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
OPAQUE = np.float32(1 / 512)
"""Transmittance below which everything behind is left out."""
MASKED = np.float32(1 / 16)
"""Samples. Wider strands can have masks of the points of a sample that they show; others may miss every point."""
PART = np.float32(0.5)
"""Share of its mask's points below which the area of a thin strand in a sample is not that of its mask."""
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


@inlined
def total_weight(out, begin, end):
    """Return the sum of the weights of the fragments begin … end − 1, from the first to the last."""
    total = ZERO
    for i in range(begin, end):
        total += out.weight[np.uint64(i)]
    return total


@inlined
def write(out, to, vertex, share, t, points):
    """Write fragment number `to` of `Fragments` with masks."""
    out.vertex[to] = np.uint32(vertex)
    out.weight[to] = share
    out.along[to] = np.float32(t & BETWEEN) * UNIT
    out.points[to] = points


@inlined
def is_narrow(screen, widths, v):
    """Return whether the segment after vertex v is drawn as cells."""
    dx, dy = screen[v + 1, 0] - screen[v, 0], screen[v + 1, 1] - screen[v, 1]
    return not is_ribbon(dx, dy, np.sqrt(dx * dx + dy * dy), max(widths[v], widths[v + 1]))


@inlined
def strand_points(table, screen, widths, v, x, y, alpha, narrow):
    """Return the mask of the points that a fragment of the segment after vertex v covers; none if it is not known.

    A narrow segment's fragment of opacity `alpha` is that of its run in the sample (see `cells`)."""
    area = alpha * np.float32(POINTS) if narrow else ZERO
    mine = covered_points(table, screen, widths, v, x, y, area)
    return NO_POINTS if narrow & (area < PART * np.float32(popcount(mine))) else mine


@device
def composite_masked(fragments, counts, ends, order, lines, table, tile, o, out, marks):
    """Write fragments as `composite` does, with masks of the points of a sample that wide strands cover: a wide strand
    hides just these points. Thin strands cover a sample independently.

    lines: `ScreenLines` with widths in samples; table: from `strandcli.draw.coverage.masks.half_planes`; other
    arguments as in `composite`.
    """
    screen, widths = lines.screen, lines.widths
    base, bits = tile.number * PIXELS, out.place_bits
    vertices = screen.shape[0]
    for p in range(np.uint64(PIXELS)):
        end = np.int64(ends[p])
        m = end - np.int64(counts[p])
        begin = o
        x = np.float32(tile.left + np.int64(p) % TILE_WIDTH) + HALF
        y = np.float32(tile.top + np.int64(p) // TILE_WIDTH) + HALF
        thin = front = room = ONE
        free = ALL_POINTS
        total, solid, previous = ZERO, False, NO_VERTEX
        while m < end:
            alpha, identity, t = numbers(fragments, order[np.uint64(m)])
            m += 1
            mine, narrow = NO_POINTS, False
            if identity < vertices and widths[identity] > MASKED:  # from `vertices` on: solids' edges
                narrow = is_narrow(screen, widths, identity)
                mine = strand_points(table, screen, widths, identity, x, y, alpha, narrow)
            if mine != NO_POINTS:
                visible = mine & free
                share = alpha * thin * np.float32(popcount(visible)) / np.float32(popcount(mine))
                free &= ~mine
            else:
                visible = free
                if abs(identity - previous) > 1:
                    front, room = thin, ONE
                previous = identity
                alpha = min(alpha, room)
                room -= alpha
                share = front * alpha * np.float32(popcount(free)) / np.float32(POINTS)
                thin = front * room
            share = min(share, ONE - total)  # areas are exact, but hidden parts are counted in points
            if share > ZERO:
                solid |= identity >= vertices
                if identity < vertices:
                    identity -= (t >> bits) & (out.stride - 1)
                    marks[np.uint64(identity)] = marks[np.uint64(identity + out.stride)] = 1
                # areas across a narrow strand are more exact than points, where nothing hides it
                points = ALL_POINTS if narrow & (visible == mine) else visible
                write(out, np.uint64(o), identity, share, t, points)
                total += share
                o += 1
            if thin * np.float32(popcount(free)) < OPAQUE * np.float32(POINTS):
                break
        if (free == NO_POINTS) & ((o > begin + 1) | (m < end)):  # all points are covered: nothing shows through
            for i in range(begin, o):
                out.weight[i] /= total
        out.counts[np.uint64(base) + p] = o - begin
        if o > begin:
            close(out, tile, np.int64(p), total_weight(out, begin, o), solid)
    return o
