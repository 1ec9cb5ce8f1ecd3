"""The end of a rod's step, a sweep from root to tip: exact lengths, contact, positions and velocities."""

from __future__ import annotations

from ...constants import W
from ...jit import device, function, inlined
from ...simd import (
    any_lane,
    broadcast,
    lane_count,
    load,
    load3,
    no_fma,
    prefetch,
    prefetch3,
    sqrt,
    store,
    store3,
    where,
)
from . import contact_forces, rod, rod_spin, rod_start
from .contact import keep_out
from .contact_spots import keep_spot, spot_of
from .records import FREE, ROUNDING, Segment
from .rod_scratch import (
    AXES,
    CORRECTION,
    CROWD_CHANGE,
    DEGENERATE,
    DISPLACEMENT,
    EDGE,
    FIRST_SEGMENT,
    IMPACT,
    INDEFINITE,
    INERTIAL,
    INVERSE_LENGTH,
    INVERSE_STEP,
    MOVED_SHARE,
    PACK,
    ROOT_SHIFT,
    SEGMENT,
    SQUARE,
    TENSION,
)
from .rod_start import GAIN, OLD_GAIN
from .rod_tension import firm_force

ROW = 3 * W
"""Numbers of a row of positions, which are drawn and lie in blocks."""
HUGE = 1e18
"""Length of an edge, or τ, from which on it counts as infinite."""
LEAST_SQUARE = 1e-12
"""|e|² up to which an edge has no direction."""
LONG = 300
"""Segments beyond which a vector of strands and its scratch do not fit the second-level cache together: what the start
of the step has read is gone by its end."""
AHEAD = 24
"""Segments that are fetched ahead then."""


@function
def sweep(s, at, next_pack, state, material, numbers, scheme, contact):
    """Bring every edge to its exact length in the direction that the iterations found, turn it out of solids, and write
    positions, velocities and tensions of the step. An edge without a finite direction stays as it was before the step.
    The state of ``next_pack`` is prefetched."""
    # u is what the iterations found and contact has added, not a difference of positions: rounding of edges must not
    # become an error of velocities, which would last
    n, strand, positions = at.segments, at.strand, state.positions
    length = load(material.lengths, strand)
    inverse_length = load(s, INVERSE_LENGTH)
    px, py, pz = load3(positions, at.position + ROW, W)
    ex, ey, ez = load3(s, FIRST_SEGMENT - SEGMENT + EDGE, 1)
    # rounded as `RodSolver.place_roots` does
    store3(positions, at.position, W, px - no_fma(length * ex), py - no_fma(length * ey), pz - no_fma(length * ez))
    store3(s, CORRECTION, 1, 0.0, 0.0, 0.0)
    store(s, DEGENERATE, 0.0)
    spun, degenerate = rod_spin.find(s, at, state, scheme, numbers[FREE] > 0)
    least = where(load(s, INDEFINITE) > 0.0, broadcast(s, 0.0), -HUGE)
    rate = 1.0 / load(s, SQUARE)
    fetched, ahead = next_pack * PACK + strand % PACK, 0
    if n > LONG:
        fetched, ahead = strand, AHEAD
    for j in range(n):
        near = min(j + ahead, n - 1)
        prefetch_segment(n, near, fetched, state, material.bends, scheme, contact.any_solids)
        row = at.edge + j * AXES
        here = at.position + (j + 2) * ROW
        o = FIRST_SEGMENT + j * SEGMENT
        degenerate = normalise(s, o, row, state.edges, numbers[ROUNDING]) or degenerate
        x, y, z = rod_start.predict(s, row, state, scheme)
        dx, dy, dz = load3(s, o + INERTIAL, 1)
        store3(s, o + DISPLACEMENT, 1, x - dx, y - dy, z - dz)
        # the next step does not begin with compression that made H indefinite
        t = max(tension_of(s, n, j, scheme.curled), least)
        store(state.tension, at.tension + j * PACK, where(abs(t) < HUGE, t * rate, 0.0))
        if contact.any_solids:
            keep_out(s, Segment(o, row, here, length, j == 0), (px, py, pz), state.positions, contact)
            keep_spot(s, spot_of(n, j, row), state.push)
        x, y, z = load3(s, CORRECTION, 1)
        ax, ay, az = load3(s, o + DISPLACEMENT, 1)
        store3(s, o + DISPLACEMENT, 1, ax + x, ay + y, az + z)
        if degenerate:
            displace_degenerate(s, o, j, row, state.edges, inverse_length)
        x, y, z = load3(s, o + EDGE, 1)
        store3(state.edges, row, PACK, x, y, z)
        px += length * x
        py += length * y
        pz += length * z
        store3(positions, here, W, px, py, pz)
        update_velocity(s, o, row, length, state, scheme, spun)
    if contact.any_solids:
        contact_forces.mark(s, at, state.touching, contact.duration)


@inlined
def tension_of(s, n, j, curled):
    """τ_j without what balances the force that keeps the edge where it is led."""
    t = load(s, FIRST_SEGMENT + j * SEGMENT + TENSION)
    if curled:
        t -= load(s, firm_force(n, j) + 3)
    return t


@inlined
def position_of(strand, n):
    """Place of a strand in the positions."""
    return strand // W * (n + 2) * ROW + strand % W


@device
def fill_block(s, positions, pack, n):
    """Set the lanes of a block after its last ``pack``, which are no strands, to the last lane of that."""
    start = position_of(pack * PACK, n) - pack * PACK % W
    first = (pack + 1) * PACK % W
    if first > 0:
        for row in range(start + first, start + (n + 2) * ROW, W):
            last = broadcast(s, positions[row - 1])
            for lane in range(0, W - first, lane_count(s)):
                store(positions, row + lane, last)


@device
def prefetch_segment(n, j, strand, state, bends, scheme, solids):
    """Prefetch the state of segment j of a strand."""
    # one segment of the next pack with each of this one: all at once the processor would have to wait
    segment = strand // PACK * n + j
    row = segment * AXES + strand % PACK
    prefetch3(state.edges, row, PACK)
    prefetch3(state.velocity, row, PACK)
    prefetch3(state.before, row, PACK)
    prefetch3(state.ahead, row, PACK)
    prefetch3(state.moved, row, PACK)
    if solids:
        prefetch3(state.push, row, PACK)
    prefetch(state.tension, segment * PACK + strand % PACK)
    prefetch3(state.positions, position_of(strand, n) + (j + 2) * ROW, W)
    if scheme.curled:
        prefetch_rest(n, j, strand, state, bends)


@device
def prefetch_rest(n, j, strand, state, bends):
    """Prefetch the rest shape of segment j of a strand, and its twist."""
    pack, lane = strand // PACK, strand % PACK
    prefetch3(bends, (pack * (n + 1) + j + 1) * AXES + lane, PACK)
    prefetch(state.twist, (pack * n + j) * PACK + lane)


@device
def normalise(s, o, row, edges, rounding):
    """Bring the edge at place o to unit length, after its beginning has moved by `CORRECTION`; that becomes by how much
    its end moves. Lanes whose edge has no direction become `DEGENERATE`; returns whether there are any."""
    x, y, z = load3(s, o + EDGE, 1)
    dx, dy, dz = load3(s, CORRECTION, 1)
    x -= dx
    y -= dy
    z -= dz
    q = x * x + y * y + z * z
    size = sqrt(max(q, rod.TINY))
    exact = abs(1.0 - q) < rounding  # else every step would round it anew, and strands never come to rest
    f = where(exact, 1.0, 1.0 / size)
    g = where(exact, 0.0, (1.0 - q) / (q + size))  # f - 1
    dx = g * x
    dy = g * y
    dz = g * z
    x *= f
    y *= f
    z *= f
    good = (q > LEAST_SQUARE) & (q < HUGE * HUGE)
    degenerate = any_lane(~good)
    if degenerate:
        store(s, DEGENERATE, where(good, load(s, DEGENERATE), 1.0))
        old = load3(edges, row, PACK)
        x = where(good, x, old[0])
        y = where(good, y, old[1])
        z = where(good, z, old[2])
        dx = where(good, dx, 0.0)
        dy = where(good, dy, 0.0)
        dz = where(good, dz, 0.0)
    store3(s, o + EDGE, 1, x, y, z)
    store3(s, CORRECTION, 1, dx, dy, dz)
    return degenerate


@device
def displace_degenerate(s, o, j, row, edges, inverse_length):
    """Set the displacement of a particle in `DEGENERATE` lanes: that of the one before it plus its edge's change."""
    degenerate = load(s, DEGENERATE) > 0.0
    for c in range(3):
        past = load(s, o - SEGMENT + DISPLACEMENT + c)
        if j == 0:
            past = load(s, ROOT_SHIFT + c) * inverse_length
        u = past + load(s, o + EDGE + c) - load(edges, row + c * PACK)
        store(s, o + DISPLACEMENT + c, where(degenerate, u, load(s, o + DISPLACEMENT + c)))


@device
def update_velocity(s, o, row, length, state, scheme, spun):
    """Set the velocity that led to the displacement by BDF2, (u − (x_n − x_{n−1}) / 3) / h, and that which the next
    step goes on with. After an `IMPACT` BDF2 starts anew from u alone: it would extrapolate the jump of
    velocity, and strands bounce. After a step of Euler's method it takes the acceleration to have been the same. Where
    strands have ``spun``, of the displacement only what is across the strand goes on."""
    inverse_step = load(s, INVERSE_STEP)
    share = load(s, MOVED_SHARE)
    rate = 1 / scheme.duration
    impact = load(s, IMPACT) > 0.0
    if spun:
        rod_spin.turn(s, o)
    for c in range(3):
        u = length * load(s, o + DISPLACEMENT + c)
        p = row + c * PACK
        past = load(state.velocity, p)
        begun = past
        if scheme.crowded:
            begun += load(s, CROWD_CHANGE) * load(state.crowd, p)
        v = rate * u
        if scheme.share > 0:
            v = where(impact, v, (u - load(state.moved, p) * share) * inverse_step)
        gain = v - begun
        old = gain
        if scheme.share > 0:
            old = where(share > 0.0, past - load(state.before, p), gain)
        gain = where(impact, broadcast(s, 0.0), gain)
        old = where(impact, broadcast(s, 0.0), old)
        store(state.before, p, v - gain)
        store(state.velocity, p, v)
        store(state.ahead, p, v + GAIN * gain - OLD_GAIN * old)
        store(state.moved, p, u)
