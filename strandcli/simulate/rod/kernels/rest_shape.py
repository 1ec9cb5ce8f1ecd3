"""Curved rest shapes: what they add to c̄, and the twist of the frames that carry them (Bergou et al. 2008, "Discrete
Elastic Rods", §5).

A joint's rest is a vector m_j in the frame of the edge before it, and its energy κ_j |e_j − m_j|² / 2. Each iteration
of the step takes one of Newton's for the twist ψ, but for a bound in place of the second derivative (`torque`), which
is below 0 where frames lag by more than a quarter turn. A rest vector that is carried along also exerts a force on the
edge before the joint, and through the frames on all edges before that: with the moments T_j = κ_j e_j × m_j and twist
torques q_j the edge j feels

    T_j − T_{j+1} + q_j e_{j−1} / (1 + e_{j−1}·e_j) − q_{j+1} e_{j+1} / (1 + e_j·e_{j+1}).

Without that reaction strands of many curls gain energy from nothing. It enters through c̄, by the edges of the last
iterate. An edge that tilts by δ alone twists its frame by θ δ and turns the rests after it, χ κ θ² δ² / 2 and some κ θ²
δ² / 2, of which c̄ that stays knows nothing. So an edge is pulled to its last iterate ê by the energy σ |e − ê|² / 2
(majorisation): of edges of unit length that is the force F = σ ê, with τ the greater by σ.
"""

from __future__ import annotations

from ....constants import FOLD
from ....jit import device, inlined
from ....jit.indices import YES
from ....simd import any_lane, broadcast, load, load3, sqrt, store, store3, where
from ....simd.turning import cosine_sine
from ....simd.vectors import add_scaled, combined, cross, dot, less, matrix_product, scaled, select, sum_of
from .arrays import AXES, PACK

GREATEST_TWIST_CHANGE = 3.0
"""Radians that ψ changes by in an iteration at the most."""
LEAST_FOLD = 1e-6
"""1 + e·e' of two edges below which parallel transport from one to the other has no direction."""
FIRMEST = 0.75
"""κ θ² by which an edge that tilts turns the rests after it, at the most."""
MOST_CHANGE = 0.5
"""Change of an edge in a step that the next one goes on with, at the most."""
NEARLY = 0.01
"""Error of |a|² of a transported normal up to which the first term brings it to unit length."""
TINY = 1e-30


@device
def begin(s, at, state, material, step, c):
    """`update` for the first time in a step, by the edges that there will be if they change as in the step before: rest
    shapes follow iterates slowly."""
    change_edges(s, at, state, c, 1.0)
    update(s, at, state, material, step, c, YES)
    change_edges(s, at, state, c, -1.0)


@device
def change_edges(s, at, state, c, factor):
    """Add what edges have changed by in the step before to them, times a factor."""
    past = load3(state.moved, at.edge, PACK)
    for j in range(1, at.segments):
        moved = load3(state.moved, at.edge + j * AXES, PACK)
        by = scaled(c.inverse_length, less(moved, past))
        f = factor * min(MOST_CHANGE / sqrt(max(dot(by, by), TINY)), 1.0)
        past = moved
        edge = add_scaled(load3(s.edge, 3 * j, 1), f, by)
        store3(s.edge, 3 * j, 1, edge[0], edge[1], edge[2])


@device
def update(s, at, state, material, step, c, first):
    """Set c̄ to the rest shape by the present edges, update the twist, and what keeps edges near these. Where it is the
    ``first`` time in a step τ gets greater by that."""
    transport_frames(s, at, state, material, step)
    add_reactions(s, at, state, material, step, c, first)


@device
def transport_frames(s, at, state, material, step):
    """Transport frames along the present edges from the root to the tip: set `Scratch.target` by the last ψ, and
    eliminate the torques about edges, linear in ψ."""
    n, bend, bends, joint = at.segments, at.bend, material.bends, material.joint
    before = load3(s.edge, -3, 1)
    normal = matrix_product(step.rotation, load3(bends, bend, PACK))
    angle = a = b = broadcast(s.pivot, 0.0)
    for j in range(n):
        _, v, w = load3(bends, bend + (j + 1) * AXES, PACK)
        c, d = cosine_sine(angle)
        other = cross(before, normal)
        edge = direction(load3(s.edge, 3 * j, 1), before)
        v, w = v * c - w * d, v * d + w * c
        target = add_scaled(scaled(v, normal), w, other)
        store3(s.target, 3 * j, 1, target[0], target[1], target[2])
        turn, stiff = torque(dot(normal, edge), dot(other, edge), v, w)
        if j > 0:
            nearer = step.torsion * (joint[j - 1] if j > 1 else step.root_twist)
            after = step.torsion * joint[j] if j + 1 < n else 0.0
            stiff = joint[j] * stiff
            over = 1.0 / (nearer * (1.0 - b) + after + stiff)
            a = (joint[j] * turn + stiff * angle + nearer * a) * over
            b = after * over
            store(s.twist_offset, j, a)
            store(s.twist_factor, j, b)
        store(s.twist, j, angle)
        angle = load(state.twist, at.number + j * PACK)
        rate = 1.0 + before[0] * edge[0] + before[1] * edge[1] + before[2] * edge[2]
        rate = 1.0 / max(rate, LEAST_FOLD)
        store(s.fold, j, rate)
        normal = carried(normal, scaled(rate, sum_of(before, edge)), edge)
        before = edge


@inlined
def direction(edge, before):
    """An edge of unit length; one without a length takes the direction of the one before."""
    square = dot(edge, edge)
    return select(square < TINY, before, scaled(1.0 / sqrt(max(square, TINY)), edge))


@device
def add_reactions(s, at, state, material, step, c, first):
    """From the tip to the root: set the new ψ, and c̄ to rest vectors by it, with their reaction on edges before, and
    what keeps edges near the present ones."""
    n, joint = at.segments, material.joint
    share = 1.0 - c.damped  # of κ, that of the material without damping
    firm = 0.5 * (step.torsion + FIRMEST) * share * c.stiffness
    zero = broadcast(s.pivot, 0.0)
    none = zero, zero, zero
    stress = none  # κ (m − e) of the joint after
    next = none  # the edge after it
    sums = none  # of the forces on edges so far
    after = zero  # q / (1 + e·e') of the joint after
    angle = zero
    turn_after = zero  # κ θ² of the joint after
    edge = direction(load3(s.edge, 3 * n - 3, 1), load3(s.edge, 3 * n - 6, 1))
    for j in range(n - 1, -1, -1):
        before = direction(load3(s.edge, 3 * j - 3, 1), load3(s.edge, -3, 1))
        past = load(s.twist, j)
        now = q = zero
        if j > 0:
            now = load(s.twist_offset, j) + load(s.twist_factor, j) * angle
            now = past + min(max(now - past, -GREATEST_TWIST_CHANGE), GREATEST_TWIST_CHANGE)
            store(state.twist, at.number + (j - 1) * PACK, now)
        if j + 1 < n:
            q = (step.torsion * joint[j]) * (now - angle)
        q = q * min(load(s.fold, j), 1.0 / FOLD)
        angle = now
        # moment and twist torque of the joint after, and the twist torque of this one
        twisted = cross(edge, combined(after, next, q, before))
        pulled = add_scaled(twisted, dot(stress, edge), less(next, edge))
        sums = sum_of(sums, add_scaled(pulled, 1.0 - dot(next, edge), stress))
        # this joint's rest vector
        across = load3(s.target, 3 * j, 1)
        rest = rest_vector(before, across, load(material.bends, at.bend + (j + 1) * AXES), now - past)
        stress = scaled(joint[j], less(sum_of(rest, before), edge))
        turn = joint[j] * dot(across, across)
        f = firm * (turn + turn_after)
        if first:
            store(s.tension, j, load(s.tension, j) + f)
            store(s.firm, 4 * j + 3, f)
        store3(s.firm, 4 * j, 1, f * edge[0], f * edge[1], f * edge[2])
        turn_after = turn
        rest = add_scaled(add_scaled(load3(s.damped, 3 * j, 1), share, rest), share / joint[j], sums)
        store3(s.rest, 3 * j, 1, rest[0], rest[1], rest[2])
        next = edge
        edge = before
        after = q


@inlined
def rest_vector(before, across, along, turned):
    """The rest vector of a joint after the edge ``before``: ``along`` that, and what is ``across`` it after its frame
    has ``turned`` by an angle."""
    c, d = cosine_sine(turned)
    return add_scaled(add_scaled(scaled(along, before), c, across), d, cross(before, across))


@inlined
def torque(x, y, v, w):
    """Torque about the edge before a joint by its bend, over κ, and how fast it may fall with ψ at the most. x, y: the
    edge along both normals of the frame; v, w: its rest.

    At an angle φ from balance the energy is −ρ cos φ. Of all parabolas that touch it there and are nowhere below it,
    the flattest has the second derivative ρ sin φ / φ and is lowest at φ = 0 (de Leeuw & Lange 2009, "Sharp quadratic
    majorization in one dimension"); sin φ / φ is at most (2 + cos φ) / 3 (Cusa and Huygens)."""
    f, g = v * y - w * x, v * x + w * y
    return f, (2.0 * sqrt(f * f + g * g) + g) * (1.0 / 3.0)


@inlined
def carried(normal, fold, edge):
    """A normal in parallel transport from an edge t to the next one e: the rotation that takes t to e takes a to
    a − (a·e) (t + e) / (1 + t·e). ``fold``: (t + e) / (1 + t·e)."""
    normal = add_scaled(normal, -dot(normal, edge), fold)
    square = dot(normal, normal)
    f = 1.5 - 0.5 * square  # 1 / √: what is carried keeps its length, but for rounding and folds
    folded = abs(square - 1.0) > NEARLY
    if any_lane(folded):
        f = where(folded, 1.0 / sqrt(max(square, TINY)), f)
    return scaled(f, normal)
