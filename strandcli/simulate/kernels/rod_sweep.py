"""The end of a rod's step, from root to tip: lengths exact, edges off solids, and the velocity that led there."""

from __future__ import annotations

from ...constants import W
from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, no_fma, prefetch, prefetch3, sqrt, store, store3, where
from . import contact, rod, rod_start
from .rod import AXES, FIRST, GRIP, HARD, HIT, LOST, OFF, OVER, PACK, SEGMENT, SHIFT, TINY, D, E, T

ROW = 3 * W
"""Numbers of a row of positions, which are drawn and lie in blocks."""
HUGE = 1e18
NONE = 1e-12
LONG = 300
"""Segments beyond which a vector of strands and its scratch do not fit the second-level cache together: what the start
of the step has read is gone by its end."""
AHEAD = 24
"""Segments that are fetched ahead then."""
U = D
"""The displacement takes the place of what was left of u*."""


@device
def sweep(
    s, n, edge, tip, place, strand, coming, edges, velocity, before, moved, tension, push, touching, lengths, positions,
    numbers, second, solid, solids, whole, touched,
):  # fmt: skip
    """Every edge gets its length exactly, heading for where the iterations put its end, and is turned off the solids;
    an edge that has no direction or none that is finite stays as it was. The velocity is what led there, (u − û) / h. u
    is that of the iterations and how far the particle is put off: what rounding does to edges, an error of places, must
    not become one of velocities, which would last."""
    length = load(lengths, strand)
    over = load(s, OVER)
    px, py, pz = load3(positions, place + ROW, W)
    ex, ey, ez = load3(s, FIRST - SEGMENT + E, 1)
    # as `rod.place_roots` rounds it
    store3(positions, place, W, px - no_fma(length * ex), py - no_fma(length * ey), pz - no_fma(length * ez))
    store3(s, OFF, 1, 0.0, 0.0, 0.0)
    store(s, LOST, 0.0)
    store(s, HIT, 0.0)
    store(s, GRIP, 0.0)
    far = rod_start.alone(numbers)
    beat = numbers[0] * (1 + 1.5 * numbers[9])  # all of the step
    least = where(load(s, HARD) > 0.0, broadcast(s, 0.0), -HUGE)
    rate = 1 / (numbers[0] * numbers[0])
    y0 = broadcast(s, 0.0)
    z0 = y0
    lost = False
    fetched, ahead = coming * PACK + strand % PACK, 0
    if n > LONG:
        fetched, ahead = strand, AHEAD
    for j in range(n):
        near = min(j + ahead, n - 1)
        fetch(n, near, fetched, edges, velocity, before, moved, tension, push, positions, second, solid)
        row = edge + j * AXES
        here = place + (j + 2) * ROW
        o = FIRST + j * SEGMENT
        lost = straighten(s, o, row, edges, numbers[12]) or lost
        x, y, z = rod_start.wish(s, row, velocity, before, moved, push, numbers[9], second, touched)
        dx, dy, dz = load3(s, o + D, 1)
        store3(s, o + U, 1, x - dx, y - dy, z - dz)
        # τ / h² for the next step, which does not begin with compression that made H indefinite
        t = max(load(s, o + T), least)
        store(tension, tip + j * PACK, where(abs(t) < HUGE, t * rate, 0.0))
        if touched:
            y0, z0 = rod.yielding(s, o, y0, z0)
        if solid:
            contact.touch(
                s, o, (px, py, pz), length, row, here, velocity, push, positions, far, beat, numbers[10],
                0.25 * numbers[12], solids, whole, j == 0, touched,
            )  # fmt: skip
        x, y, z = load3(s, OFF, 1)
        ax, ay, az = load3(s, o + U, 1)
        store3(s, o + U, 1, ax + x, ay + y, az + z)
        if lost:
            turn_alone(s, o, j, row, edges, over)
        x, y, z = load3(s, o + E, 1)
        store3(edges, row, PACK, x, y, z)
        px += length * x
        py += length * y
        pz += length * z
        store3(positions, here, W, px, py, pz)
        settle(s, o, row, length, velocity, before, moved, numbers, second)
    if solid:
        store(touching, strand, where(load(s, GRIP) > 0.0, broadcast(s, 1.0), 0.0))


@inlined
def place_of(strand, n):
    """Where positions of a strand begin."""
    return strand // W * (n + 2) * ROW + strand % W


@device
def fetch(n, j, strand, edges, velocity, before, moved, tension, push, positions, second, solid):
    """Have the processor fetch what the step has of segment j of a strand: of one to come, of which none has been used
    since the step before, and asked for all at once it would be waited for; of a long one itself."""
    segment = strand // PACK * n + j
    row = segment * AXES + strand % PACK
    prefetch3(edges, row, PACK)
    prefetch3(velocity, row, PACK)
    if second:
        prefetch3(before, row, PACK)
        prefetch3(moved, row, PACK)
    if solid:
        prefetch3(push, row, PACK)
    prefetch(tension, segment * PACK + strand % PACK)
    prefetch3(positions, place_of(strand, n) + (j + 2) * ROW, W)


@device
def straighten(s, o, row, edges, rounding):
    """Edge o, where it begins put off by OFF, gets unit length, which puts its end off. LOST where it has no direction
    to keep, from there on; returns whether there are such lanes."""
    x, y, z = load3(s, o + E, 1)
    dx, dy, dz = load3(s, OFF, 1)
    x -= dx
    y -= dy
    z -= dz
    q = x * x + y * y + z * z
    size = sqrt(max(q, TINY))
    exact = abs(1.0 - q) < rounding  # or every step would round it anew, and never to rest
    f = where(exact, 1.0, 1.0 / size)
    g = where(exact, 0.0, (1.0 - q) / (q + size))  # f - 1
    dx = g * x
    dy = g * y
    dz = g * z
    x *= f
    y *= f
    z *= f
    good = (q > NONE) & (q < HUGE * HUGE)
    lost = any_lane(~good)
    if lost:
        store(s, LOST, where(good, load(s, LOST), 1.0))
        old = load3(edges, row, PACK)
        x = where(good, x, old[0])
        y = where(good, y, old[1])
        z = where(good, z, old[2])
        dx = where(good, dx, 0.0)
        dy = where(good, dy, 0.0)
        dz = where(good, dz, 0.0)
    store3(s, o + E, 1, x, y, z)
    store3(s, OFF, 1, dx, dy, dz)
    return lost


@device
def turn_alone(s, o, j, row, edges, over):
    """The displacement of a particle in lanes that are LOST: that of the one before it, and how its edge has turned."""
    lost = load(s, LOST) > 0.0
    for c in range(3):
        past = load(s, SHIFT + c) * over if j == 0 else load(s, o - SEGMENT + U + c)
        u = past + load(s, o + E + c) - load(edges, row + c * PACK)
        store(s, o + U + c, where(lost, u, load(s, o + U + c)))


@device
def settle(s, o, row, length, velocity, before, moved, numbers, second):
    """The velocity that led to the displacement. From where a strand has been HIT on, it goes on from that alone: BDF2
    would take a jump of velocity further, and strands bounce."""
    over = 1 / numbers[0]
    if second:
        third = numbers[9]
        rate = over / (1 + 1.5 * third)
        hit = load(s, HIT) > 0.0
        for c in range(3):
            sum = length * load(s, o + U + c)
            p = row + c * PACK
            past = load(velocity, p)
            v = where(hit, rate * sum, (sum - load(moved, p) * third) * over)
            store(before, p, where(hit, v, past))
            store(velocity, p, v)
            store(moved, p, sum)
    else:
        for c in range(3):
            store(velocity, row + c * PACK, length * load(s, o + U + c) * over)
