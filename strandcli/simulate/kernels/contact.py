"""Contact of rods, edge by edge from root to tip: an edge whose end is in a solid is turned until it is not.

The edge keeps its length, so its particle stays on a sphere about the one before it. Of that sphere the solid allows
the directions d whose product with one axis is at most some limit, d·a <= c. For a ball of radius r about o, with a
unit vector a toward o and D = |o − q|, c = (ℓ² + D² − r²) / (2 ℓ D); for a flat face with the normal −a, c = (height of
q above it) / ℓ. Where d·a = c the edge ends on a circle about the axis, to which it is taken straight across the axis.
Lengths stay exact, and there is no penalty term.

Force. Newton's iterations come before this and would bend a strand that leans on a solid as if nothing were there; what
turning edges leaves of that depends on the step. So the force of contact is kept from step to step, as the acceleration
of the particle that it acts on, and takes part in the iterations: it is the multiplier of an augmented Lagrangian,
updated once a step (Nocedal & Wright 2006, §17.3). A particle that comes to lie at depth δ, where the force of the step
before came to λ, has

    λ' = max(0, λ + w δ),  held at the surface where λ' > 0, set free from λ where not,

and across the normal the same with the distance that it slid, at most μ λ' (Coulomb's law). Both are displacements,
forces times h²; w is how many times as heavy as the particle all is that such forces on the strand move: with H of the
iterations and χ = 1 where there are forces, 1 / w = H⁻¹ M χ. That bounds the row sums of what forces lead to, so that
all may be updated at once without overshoot. At rest δ = 0, and a strand leans on a solid as at any other step. Depth
that comes from velocity alone, an impact, is no force kept.
"""

from __future__ import annotations

from ...constants import W
from ...jit import inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, store, store3, where
from .contact_circle import STEEP, contact_circle, intersection_of_circles, perpendicular
from .contact_place import CARRIED, CENTRE, ROUND, SIZE
from .contact_search import PARTICLE, STARTS, direction, segment_depth
from .contact_shapes import TINY, edges_of, nearest
from .rod_scratch import CONTACT_FORCE, CORRECTION, EDGE, IMPACT, INVERSE_LENGTH, MOBILITY, PACK
from .vectors import add_scaled, dot, select

SLACK = 1e-6
"""Depth, as a share of an edge, up to which it counts as rounding; far from the origin that of coordinates is more."""
ROUNDS = 3
"""Turns out of solids that overlap; twice as many where whole edges are kept out, and then as many of the end alone."""
DEEP = 0.05
"""Depth of a segment, as a share of it, from which on other directions are tried. Two halves of an edge across a corner
lie up to some hundredths deep when at rest; trying others there would move them at every step."""
UNBOUND = 1e18
"""Limit of d·axis where no solid has turned an edge yet."""
LEAST_MOBILITY = 1e-6
"""Least share of its own mobility that a particle is taken to have."""


@inlined
def turn_out_of_solids(s, segment, q, d, positions, contact):
    """The unit edge d from q, turned until its end is in no solid.

    One solid after the other turns it, the deepest first. Where whole edges are kept out, turns to and fro may never
    end: what one solid asks for, another forbids. So an edge that would be turned back into the solid before goes to
    the intersection of the two circles, and then its end is turned out alone: no segment is kept out at the price of
    its particle. Where that leaves an end inside, or much of the segment, it is tried again from other directions."""
    length, whole = segment.length, contact.segments
    # without slack, short edges would be turned for the rounding of where they begin, again and again
    slack = max(SLACK * length, contact.rounding * (abs(q[0]) + abs(q[1]) + abs(q[2])))
    enough = DEEP * length
    at = positions, segment.position
    zero = broadcast(length, 0.0)
    last, last_inverse, limit = (zero, zero, zero), zero, broadcast(length, UNBOUND)
    with_edges, left, start = whole, 2 * ROUNDS, 0
    begin, best, least = d, d, broadcast(length, UNBOUND)
    for _ in range((STARTS + 1) * (3 * ROUNDS + 2) if whole else ROUNDS):
        edges = edges_of(s, segment.scratch, d, length, with_edges, segment.first)
        depth, found = nearest(s, add_scaled(q, length, d), edges, at, -slack, contact.solids)
        inside = depth > slack
        if whole:
            if not with_edges:
                edge = length * d[0], length * d[1], length * d[2]
                cost = segment_depth(q, edge, segment.first, contact.solids) + where(inside, PARTICLE * depth, 0.0)
                best, least = select(cost < least, d, best), min(cost, least)
            lost = least > enough
            inside = inside & lost
            if left == 0 or not any_lane(inside):
                if not with_edges:
                    if start == STARTS or not any_lane(lost):
                        break
                    d = select(lost, direction(begin, start), best)
                    start += 1
                with_edges = not with_edges and start > 1
                left = 2 * ROUNDS if with_edges else ROUNDS
                limit = broadcast(length, UNBOUND)
                continue
        elif not any_lane(inside):
            break
        left -= 1
        axis, inverse, share, square = contact_circle(s, found, q, load(s, INVERSE_LENGTH))
        turned = add_scaled(perpendicular(d, axis, inverse, square), share, axis)
        if whole:
            bound = share / inverse
            back = inside & (dot(turned, last) > limit)
            if any_lane(back):
                crossing, there = intersection_of_circles(d, last, last_inverse, limit, axis, inverse, bound)
                turned = select(back & there, crossing, turned)
            last, last_inverse = select(inside, axis, last), where(inside, inverse, last_inverse)
            limit = where(inside, bound, limit)
        d = select(inside, turned, d)
        if not any_lane(inside & (square > 0.0)):  # those from too deep inside are as far out as they get
            if not whole:
                break
            left = 0
    if whole:
        d = best
    return d


@inlined
def resolve_contact(s, segment, q, state, contact, pressed):
    """Turn the unit edge of a segment that begins at q out of all solids, update the force on its particle, and add the
    particle's displacement to `CORRECTION`. ``pressed``: whether any lane has forces of the step before."""
    length, push = segment.length, state.push
    d = load3(s, segment.scratch + EDGE, 1)
    end = add_scaled(q, length, d)
    zero = broadcast(length, 0.0)
    reach, mobility, held = zero, broadcast(length, 1.0), (zero, zero, zero)
    if pressed:
        reach, mobility, held = held_displacement(s, segment, push, contact.reach)
    was = reach > 0.0
    edges = edges_of(s, segment.scratch, d, length, contact.segments, segment.first)
    depth, found = nearest(s, end, edges, (state.positions, segment.position), reach, contact.solids)
    if not any_lane((depth > -reach) | was):
        return
    inverse_length = load(s, INVERSE_LENGTH)
    n = normal_at(s, found, end, depth)
    force = max(dot(held, n), 0.0) + depth
    near = (depth > -reach) & (force > 0.0)
    free = was & ~near
    turned = d
    if any_lane(free):
        turned = select(free, released(d, inverse_length, held), d)
    if any_lane(near):
        axis, inverse, share, square = contact_circle(s, found, q, inverse_length)
        # of the displacement that held the particle before, what was across the normal
        held = add_scaled(held, -dot(held, n), n)
        kept = friction(held, slide(s, found, end, d, n, depth), n, contact.friction * force)
        p = add_scaled(d, inverse_length, add_scaled(kept, -1.0, held))
        p = perpendicular(p, axis, inverse, square)
        turned = select(near, add_scaled(p, share, axis), turned)
        kept = add_scaled(kept, force, n)
        # an edge from too deep inside to end at the surface is only turned: no force of its depth would be right
        f = where(square > 0.0, 1.0 / (contact.reach * mobility), 0.0)
        new = near & ~was
        if any_lane(new):
            resting = resting_depth(s, found, segment, state, n, depth, contact.duration)
            f = where(new, f * resting / max(depth, TINY), f)
            store(s, IMPACT, load(s, IMPACT) + where(new, broadcast(f, 1.0), 0.0))
        ax, ay, az = select(near, (f * kept[0], f * kept[1], f * kept[2]), (zero, zero, zero))
        store3(push, segment.row, PACK, ax, ay, az)
        store(s, CONTACT_FORCE, load(s, CONTACT_FORCE) + (abs(ax) + abs(ay) + abs(az)))
    else:
        store3(push, segment.row, PACK, 0.0, 0.0, 0.0)
    turned = turn_out_of_solids(s, segment, q, turned, state.positions, contact)
    store3(s, segment.scratch + EDGE, 1, turned[0], turned[1], turned[2])
    x, y, z = load3(s, CORRECTION, 1)
    store3(s, CORRECTION, 1, x + turned[0] - d[0], y + turned[1] - d[1], z + turned[2] - d[2])


@inlined
def held_displacement(s, segment, push, reach):
    """What the force of the step before has done to a particle: an upper bound of how far it displaced it, 0 where
    there was none; the particle's mobility, 1 / w, as a share of its own; and the displacement. ``reach``: displacement
    of a free particle by 1 m/s²."""
    ax, ay, az = load3(push, segment.row, PACK)
    size = abs(ax) + abs(ay) + abs(az)
    # of particles without a force, `MOBILITY` tells only how far forces on others move them
    mobility = where(size > 0.0, load(s, segment.scratch + MOBILITY), 0.0)
    mobility = where(mobility > 0.0, min(max(mobility, LEAST_MOBILITY), 1.0), 1.0)
    f = reach * mobility
    return size * f, mobility, (f * ax, f * ay, f * az)


@inlined
def normal_at(s, found, end, depth):
    """Unit normal at a particle of the solid in slot ``found``, which it is ``depth`` deep in."""
    round = load(s, found + ROUND) > 0.0
    centre = load3(s, found + CENTRE, 1)
    x, y, z = end[0] - centre[0], end[1] - centre[1], end[2] - centre[2]
    away = load(s, found + SIZE) - depth
    deep = round & (depth > away)
    if any_lane(deep):  # of a small distance from the centre, a great radius less depth leaves nothing
        away = where(deep, sqrt(x * x + y * y + z * z), away)
    away = 1.0 / max(away, TINY)
    return select(round, (away * x, away * y, away * z), centre)


@inlined
def released(d, inverse_length, held):
    """The unit edge d without the displacement that ``held`` its end."""
    e = add_scaled(d, -inverse_length, held)
    f = 1.0 / sqrt(max(dot(e, e), TINY))
    return f * e[0], f * e[1], f * e[2]


@inlined
def slide(s, found, end, d, n, depth):
    """How far a particle slides on the solid in slot ``found`` in this step: from where the solid has carried it to
    where the edge, turned about its beginning, ends at the surface."""
    f = dot(d, n)
    turned = f * (depth / max(1.0 - f * f, STEEP))
    carried = load3(s, found + CARRIED, 1)
    return add_scaled((end[0] - carried[0], end[1] - carried[1], end[2] - carried[2]), -turned, d)


@inlined
def friction(held, way, n, most):
    """The displacement by friction across the normal n: ``held``, that of the step before, less the ``way`` that the
    particle slides, at most ``most`` long (Coulomb's law)."""
    kept = add_scaled(add_scaled(held, -1.0, way), dot(way, n), n)
    f = min(sqrt(most * most / max(dot(kept, kept), TINY)), 1.0)
    return f * kept[0], f * kept[1], f * kept[2]


@inlined
def resting_depth(s, found, segment, state, n, depth, duration):
    """What of the depth of a particle that has met a solid anew its velocity before the step does not account for. The
    rest is an impact, no force that stays."""
    v = load3(state.velocity, segment.row, PACK)
    before = load3(state.positions, segment.position, W)
    carried = load3(s, found + CARRIED, 1)
    way = carried[0] - before[0], carried[1] - before[1], carried[2] - before[2]
    fall = dot(n, way) - duration * dot(n, v)
    return max(depth - max(fall, 0.0), 0.0)
