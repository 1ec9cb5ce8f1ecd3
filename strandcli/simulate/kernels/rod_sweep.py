"""The end of a rod's step, from root to tip: lengths exact, edges off solids, and the velocity that led there."""

from __future__ import annotations

from ...constants import W
from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, no_fma, prefetch, prefetch3, sqrt, store, store3, where
from . import rod, rod_start
from .contact import touch
from .records import ROUNDING, STEP, THIRD, Segment
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
def sweep(s, at, next_pack, state, lengths, numbers, scheme, contact):
    """Give every edge exactly its length in the direction that the iterations found, turn it off the solids, and set
    the velocity (u − û) / h. An edge that has no finite direction stays as it was."""
    # u is that of the iterations and what contact adds, not a difference of positions: what rounding does to edges must
    # not become an error of velocities, which would last
    n, strand, positions = at.segments, at.strand, state.positions
    length = load(lengths, strand)
    over = load(s, OVER)
    px, py, pz = load3(positions, at.position + ROW, W)
    ex, ey, ez = load3(s, FIRST - SEGMENT + E, 1)
    # as `rod.place_roots` rounds it
    store3(positions, at.position, W, px - no_fma(length * ex), py - no_fma(length * ey), pz - no_fma(length * ez))
    store3(s, OFF, 1, 0.0, 0.0, 0.0)
    store(s, LOST, 0.0)
    store(s, HIT, 0.0)
    store(s, GRIP, 0.0)
    least = where(load(s, HARD) > 0.0, broadcast(s, 0.0), -HUGE)
    rate = 1 / (numbers[STEP] * numbers[STEP])
    y0 = broadcast(s, 0.0)
    z0 = y0
    lost = False
    fetched, ahead = next_pack * PACK + strand % PACK, 0
    if n > LONG:
        fetched, ahead = strand, AHEAD
    for j in range(n):
        near = min(j + ahead, n - 1)
        fetch(n, near, fetched, state, scheme.second, contact.any_solids)
        row = at.edge + j * AXES
        here = at.position + (j + 2) * ROW
        o = FIRST + j * SEGMENT
        lost = straighten(s, o, row, state.edges, numbers[ROUNDING]) or lost
        x, y, z = rod_start.predict(s, row, state, scheme)
        dx, dy, dz = load3(s, o + D, 1)
        store3(s, o + U, 1, x - dx, y - dy, z - dz)
        # τ / h² for the next step, which does not begin with compression that made H indefinite
        t = max(load(s, o + T), least)
        store(state.tension, at.tension + j * PACK, where(abs(t) < HUGE, t * rate, 0.0))
        if scheme.pressed:
            y0, z0 = rod.yielding(s, o, y0, z0)
        if contact.any_solids:
            touch(s, Segment(o, row, here, length, j == 0), (px, py, pz), state, contact, scheme.pressed)
        x, y, z = load3(s, OFF, 1)
        ax, ay, az = load3(s, o + U, 1)
        store3(s, o + U, 1, ax + x, ay + y, az + z)
        if lost:
            turn_alone(s, o, j, row, state.edges, over)
        x, y, z = load3(s, o + E, 1)
        store3(state.edges, row, PACK, x, y, z)
        px += length * x
        py += length * y
        pz += length * z
        store3(positions, here, W, px, py, pz)
        settle(s, o, row, length, state, numbers, scheme.second)
    if contact.any_solids:
        store(state.touching, strand, where(load(s, GRIP) > 0.0, broadcast(s, 1.0), 0.0))


@inlined
def position_of(strand, n):
    """Where positions of a strand begin."""
    return strand // W * (n + 2) * ROW + strand % W


@device
def fetch(n, j, strand, state, second, solids):
    """Prefetch the state of segment j of a strand."""
    # of the next pack, one segment at a time: all at once the processor would have to wait; of a long strand its own
    segment = strand // PACK * n + j
    row = segment * AXES + strand % PACK
    prefetch3(state.edges, row, PACK)
    prefetch3(state.velocity, row, PACK)
    if second:
        prefetch3(state.before, row, PACK)
        prefetch3(state.moved, row, PACK)
    if solids:
        prefetch3(state.push, row, PACK)
    prefetch(state.tension, segment * PACK + strand % PACK)
    prefetch3(state.positions, position_of(strand, n) + (j + 2) * ROW, W)


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
def settle(s, o, row, length, state, numbers, second):
    """The velocity that led to the displacement. From where a strand has been HIT on, it goes on from that alone: BDF2
    would take a jump of velocity further, and strands bounce."""
    over = 1 / numbers[STEP]
    if second:
        third = numbers[THIRD]
        rate = over / (1 + 1.5 * third)
        hit = load(s, HIT) > 0.0
        for c in range(3):
            sum = length * load(s, o + U + c)
            p = row + c * PACK
            past = load(state.velocity, p)
            v = where(hit, rate * sum, (sum - load(state.moved, p) * third) * over)
            store(state.before, p, where(hit, v, past))
            store(state.velocity, p, v)
            store(state.moved, p, sum)
    else:
        for c in range(3):
            store(state.velocity, row + c * PACK, length * load(s, o + U + c) * over)
