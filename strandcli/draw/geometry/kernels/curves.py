"""Smooth polylines from particles (thesis §3): each segment becomes a cubic Bézier curve, cut into straight pieces.

Tangents point from root to tip, the opposite of the source's sign, so the control points of the segment p_{i-1} p_i are
p_{i-1} + t_{i-1} L / 3 and p_i − t_i L / 3. The first tangent is the strand's direction, the last is zero.
"""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, inlined, parallel, prange
from ...common.kernels.numbers import ONE, THREE, TWO, ZERO
from .tangents import LANES, find_tangents

THIRD = np.float32(1 / 3)
TINY = np.float32(1e-30)


@parallel
def flatten(positions, lengths, strands, pieces, fixed, as_printed, first, world, along):
    """Write the polylines of strands.

    positions (blocks, n + 1, 3 W), metres; lengths (blocks, W), or None: those of the chords; pieces (strands, n − 1)
    uint16, or (0, 0): every segment has `fixed` pieces; as_printed: whether tangents are computed as the source prints
    them; first (strands + 1,) int64 vertex offsets; world (V, 3) float32,
    metres, written; along (V,) float32: how far along its strand each vertex stands, 0 at the root to 1 at the tip,
    written if it has rows.
    """
    straight = pieces.shape[0] == 0 and fixed == 1
    for group in prange((strands + LANES - 1) // LANES):
        begin = np.int64(group) * LANES
        end = min(begin + LANES, strands)
        if first[end] != first[begin]:
            tangents = np.empty(0 if straight else 3 * LANES * positions.shape[1], np.float32)
            if not straight:
                find_tangents(positions, begin, lengths, as_printed, tangents)
            for s in range(begin, end):
                if first[s + 1] == first[s]:
                    continue
                write_polyline(positions[s // W], lengths, s, pieces, fixed, tangents, first[s], world)
                if along.shape[0] > 0:
                    write_along(pieces[s], along, first[s])


@inlined
def write_polyline(block, lengths, s, pieces, fixed, tangents, v, world):
    """Write the polyline of strand s, in a block (n + 1, 3 W), from vertex v on; tangents: from `find_tangents`; other
    arguments as in `flatten`."""
    n = block.shape[0] - 1
    lane = s % W
    ax, ay, az = block[1, lane], block[1, W + lane], block[1, 2 * W + lane]
    third = ZERO if lengths is None else lengths[s // W, lane] * THIRD
    write_vertex(world, v, ax, ay, az)
    for i in range(1, n):
        m = np.int64(fixed) if pieces.shape[0] == 0 else np.int64(pieces[s, i - 1])
        bx, by, bz = block[i + 1, lane], block[i + 1, W + lane], block[i + 1, 2 * W + lane]
        ex, ey, ez = bx - ax, by - ay, bz - az
        per = ONE / np.float32(m)
        if m > 1:
            before, after = 3 * (i - 1) * LANES + s % LANES, 3 * i * LANES + s % LANES
            if lengths is None:
                third = norm(ex, ey, ez) * THIRD
            tx, sx = tangents[before] * third, tangents[after] * third
            ty, sy = tangents[before + LANES] * third, tangents[after + LANES] * third
            tz, sz = tangents[before + 2 * LANES] * third, tangents[after + 2 * LANES] * third
            for j in range(1, m):
                t = np.float32(j) * per
                write_vertex(
                    world, v + j, bezier(t, ax, ex, tx, sx), bezier(t, ay, ey, ty, sy), bezier(t, az, ez, tz, sz)
                )
        v += m
        write_vertex(world, v, bx, by, bz)
        ax, ay, az = bx, by, bz


@inlined
def write_along(pieces, along, v):
    """Write how far along its strand each vertex from number v on stands; pieces (n − 1,): of its segments."""
    segments = pieces.shape[0]
    per = ONE / np.float32(segments)
    along[v] = ZERO
    for i in range(segments):
        m = np.int64(pieces[i])
        step = per / np.float32(m)
        for j in range(m):
            v += 1
            along[v] = min(np.float32(i) * per + np.float32(j + 1) * step, ONE)


@inlined
def write_vertex(world, v, x, y, z):
    """Write the position of one vertex."""
    world[v, 0] = x
    world[v, 1] = y
    world[v, 2] = z


@inlined
def bezier(t, a, e, g, h):
    """Return a coordinate at t, 0 to 1, of the Bézier curve with the control points a, a + g, a + e − h and a + e."""
    return a + t * (THREE * g + t * (THREE * (e - TWO * g - h) + t * (THREE * (g + h) - TWO * e)))


@device
def norm(x, y, z):
    """Return the length of a vector."""
    return np.sqrt(x * x + y * y + z * z)


SHARED = 256
"""Strands a task."""


@parallel
def find_shares(first, along, shares, out):
    """Write the share of its strand's width that each vertex has, out (V,) float32.

    first (S + 1,) int64: first vertex of each strand; along (V,): how far along its strand each vertex stands, 0 to 1,
    or None: evenly; shares (S, n) float32: at its n points, which stand evenly, linear between them.
    """
    strands = first.shape[0] - 1
    last = np.int64(shares.shape[1] - 1)
    for task in prange((strands + SHARED - 1) // SHARED):
        for s in range(np.int64(task) * SHARED, min((np.int64(task) + 1) * SHARED, strands)):
            begin = first[s]
            per = ONE / np.float32(max(first[s + 1] - begin - 1, 1))
            for v in range(begin, first[s + 1]):
                place = np.float32(v - begin) * per if along is None else along[v]
                at = place * np.float32(last)
                i = min(np.int64(at), last - 1)
                t = min(at - np.float32(i), ONE)
                out[v] = (ONE - t) * shares[s, i] + t * shares[s, i + 1]


@parallel
def shorten(first, world, fade):
    """Shorten each strand that fades to the fraction `fade` of its length from the root; vertices beyond that are moved
    to the new tip.

    first (S + 1,) int64; world (V, 3) metres, changed; fade (S,).
    """
    for s in prange(fade.shape[0]):
        if fade[s] < ONE:
            shorten_one(world, first[s], first[s + 1], fade[s])


@device
def shorten_one(world, begin, end, part):
    """Shorten the polyline begin … end − 1 to a fraction of its length."""
    left = ZERO
    for v in range(begin + 1, end):
        left += distance(world, v - 1, v)
    left *= part
    for v in range(begin + 1, end):
        length = distance(world, v - 1, v)
        t = min(left / max(length, TINY), ONE)
        left -= t * length
        if t < ONE:
            for c in range(3):
                world[v, c] = world[v - 1, c] + t * (world[v, c] - world[v - 1, c])
            for w in range(v + 1, end):
                for c in range(3):
                    world[w, c] = world[v, c]
            return


@device
def distance(world, v, w):
    """Return the distance between two vertices."""
    return norm(world[w, 0] - world[v, 0], world[w, 1] - world[v, 1], world[w, 2] - world[v, 2])
