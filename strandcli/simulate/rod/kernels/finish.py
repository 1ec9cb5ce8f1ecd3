"""The end of a rod's step, a sweep from root to tip: exact lengths, solids, positions and velocities."""

from __future__ import annotations

from ....constants import W
from ....jit import device, inlined
from ....simd import (
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
from ....simd.vectors import add_scaled, dot, less, scaled, select, sum_of
from ...contact.kernels import find
from ...contact.kernels.search import Past
from .arrays import AXES, PACK, ROW
from .begin import GAIN, OLD_GAIN

HUGE = 1e18
"""Length of an edge, or τ, from which on it counts as infinite."""
LEAST_SQUARE = 1e-12
"""|e|² up to which an edge has no direction."""
TINY = 1e-30


@inlined
def position_of(strand, n):
    """Place of a strand in the positions."""
    return strand // W * (n + 2) * ROW + strand % W


@device
def finish(s, at, next_pack, state, bends, step, needs, c, met, shift):
    """Bring every edge to its exact length in the direction that the iterations found, turn it out of solids where
    these are near, and write positions, velocities, tensions and forces. An edge without a finite direction stays as it
    was before the step. ``met``: `Contact`, and whether solids are near; ``shift``: displacement of the root, metres.
    The state of ``next_pack`` is prefetched."""
    # u is what the iterations found and this sweep has added, not a difference of positions: rounding of edges must not
    # become an error of velocities, which would last
    n, positions, length = at.segments, state.positions, c.length
    contact, near = met
    root = load3(positions, at.position + ROW, W)
    x, y, z = load3(s.edge, -3, 1)
    # rounded as `RodSolver.place_roots` does
    store3(
        positions, at.position, W, root[0] - no_fma(length * x), root[1] - no_fma(length * y),
        root[2] - no_fma(length * z),
    )  # fmt: skip
    zero = length * 0.0
    correction, past = (zero, zero, zero), scaled(c.inverse_length, shift)
    restart = zero
    if needs.solids:
        restart = mark_changes(s, at, state, needs, c)
    begun = jump = max(restart, load(state.restart, at.strand))
    end = root
    bad = zero < 0.0
    inverse_reach = 1.0 / c.reach
    for j in range(n):
        prefetch_segment(n, j, next_pack * PACK + at.strand % PACK, state, bends, needs)
        row = at.edge + j * AXES
        correction, bad = normalise(s, j, state.edges, row, correction, bad, step.rounding)
        if near:
            past_end = Past(positions, at.position + (j + 2) * ROW, (zero, zero, zero))
            correction = find.turn_out(s, j, end, correction, c, contact, past_end, needs.segments)
        edge = load3(s.edge, 3 * j, 1)
        free, left = load3(s.free, 3 * j, 1), load3(s.inertial, 3 * j, 1)
        u = sum_of(less(free, left), correction)
        if any_lane(bad):
            u = select(bad, less(sum_of(past, edge), load3(state.edges, row, PACK)), u)
        past = u
        t = load(s.tension, j) - load(s.firm, 4 * j + 3)
        store(state.tension, at.number + j * PACK, where(abs(t) < HUGE, t * inverse_reach, 0.0))
        store3(state.edges, row, PACK, edge[0], edge[1], edge[2])
        end = add_scaled(end, length, edge)
        store3(positions, at.position + (j + 2) * ROW, W, end[0], end[1], end[2])
        if needs.solids:
            f = load3(state.force, row, PACK)
            jump = where(abs(f[0]) + abs(f[1]) + abs(f[2]) > 0.0, begun, restart)
        set_velocity(state, row, u, needs, c, (restart, jump))
    store(state.restart, at.strand, restart)


@inlined
def normalise(s, j, edges, row, correction, bad, rounding):
    """Bring edge j to unit length, after its beginning has moved by the ``correction``; return by how much its end
    moves, and in which lanes this edge or one before it has no direction: it stays as it was."""
    edge = less(load3(s.edge, 3 * j, 1), correction)
    q = dot(edge, edge)
    size = sqrt(max(q, TINY))
    exact = abs(1.0 - q) < rounding  # else every step would round it anew, and strands never come to rest
    by = scaled(where(exact, 0.0, (1.0 - q) / (q + size)), edge)
    edge = scaled(where(exact, 1.0, 1.0 / size), edge)
    good = (q > LEAST_SQUARE) & (q < HUGE * HUGE)
    if any_lane(~good):
        zero = broadcast(q, 0.0)
        bad = bad | ~good
        edge, by = select(good, edge, load3(edges, row, PACK)), select(good, by, (zero, zero, zero))
    store3(s.edge, 3 * j, 1, edge[0], edge[1], edge[2])
    return by, bad


@device
def mark_changes(s, at, state, needs, c):
    """Write the forces of contact; return 1 in lanes where solids touch other segments than before the step: BDF2 would
    go on with forces that have come or gone."""
    zero = c.length * 0.0
    changed = zero
    scale = c.length / c.reach
    for j in range(at.segments):
        row = at.edge + j * AXES
        x, y, z = load3(state.force, row, PACK)
        before = (abs(x) + abs(y) + abs(z)) > 0.0
        force = load3(s.force, 3 * j, 1)
        now = (load(s.active, j) > 0.0) & (dot(force, load3(s.normal, 3 * j, 1)) >= 0.0)
        changed = where((before & ~now) | (now & ~before), 1.0, changed)
        x, y, z = select(now, scaled(scale, force), (zero, zero, zero))
        store3(state.force, row, PACK, x, y, z)
        if needs.segments:
            store(state.share, at.number + j * PACK, load(s.share, j))
    return changed


@inlined
def set_velocity(state, row, u, needs, c, jumps):
    """Set the velocity that led to the displacement u: by Euler's method u / h; by BDF2 (u − (x_n − x_{n−1}) / 3) / h,
    and that which the next step goes on with. ``jumps``: where that will restart, by u / Δt, and where velocities
    jump in this step, which BDF2 would extrapolate."""
    restart, jump = jumps
    rate = 1.0 / c.duration
    for k in range(3):
        p = row + k * PACK
        moved = c.length * u[k]
        begun = past = load(state.velocity, p)
        if needs.pushed:
            begun += c.push_change * load(state.acceleration, p)
        v = (moved - load(state.moved, p) * c.moved_share) * c.inverse_step
        v = where(restart > 0.0, rate * moved, v)
        gain = where(jump > 0.0, 0.0, v - begun)
        old = where(jump > 0.0, 0.0, where(c.moved_share > 0.0, past - load(state.before, p), v - begun))
        store(state.before, p, v - gain)
        store(state.velocity, p, v)
        store(state.ahead, p, v + GAIN * gain - OLD_GAIN * old)
        store(state.moved, p, moved)


@inlined
def prefetch_segment(n, j, strand, state, bends, needs):
    """Prefetch the state of segment j of a strand."""
    # one segment of the next pack with each of this one: all at once the processor would have to wait
    segment = strand // PACK * n + j
    row = segment * AXES + strand % PACK
    prefetch3(state.edges, row, PACK)
    prefetch3(state.velocity, row, PACK)
    prefetch3(state.before, row, PACK)
    prefetch3(state.ahead, row, PACK)
    prefetch3(state.moved, row, PACK)
    if needs.solids:
        prefetch3(state.force, row, PACK)
    prefetch(state.tension, segment * PACK + strand % PACK)
    prefetch3(state.positions, position_of(strand, n) + (j + 2) * ROW, W)
    if needs.curled:
        pack, lane = strand // PACK, strand % PACK
        prefetch3(bends, (pack * (n + 1) + j + 1) * AXES + lane, PACK)
        prefetch(state.twist, (pack * n + j) * PACK + lane)


@device
def fill_block(s, positions, pack, n):
    """Set the lanes of a block after its last ``pack``, which are no strands, to the last lane of that."""
    start = position_of(pack * PACK, n) - pack * PACK % W
    first = (pack + 1) * PACK % W
    if first > 0:
        for row in range(start + first, start + (n + 2) * ROW, W):
            last = broadcast(s.pivot, positions[row - 1])
            for lane in range(0, W - first, lane_count(s.pivot)):
                store(positions, row + lane, last)
