"""Contact of rods, edge by edge from root to tip: an edge whose end is in a solid is rotated until it is outside.

The edge keeps its length, so its particle stays on a sphere around the one before it. The solid allows the directions d
for which d·a <= c, where a is an axis. For a ball of radius r about o, with a unit vector a toward o and D = |o − q|, c
= (ℓ² + D² − r²) / (2 ℓ D); for a flat face with the normal −a, c = (height of q above it) / ℓ. If it is violated, the
edge is projected onto the circle d·a = c, perpendicularly to the axis. Lengths stay exact, and there is no penalty
term.

Force. Newton's iterations precede contact and would bend a strand that leans on a solid as if there were none; what the
rotation leaves of that depends on the step. So the contact force is kept from step to step, as an acceleration of its
particle, and takes part in the iterations: it is the multiplier of an augmented Lagrangian, updated once a step
(Nocedal & Wright 2006, §17.3). A particle at depth δ, with the multiplier λ of the step before, gets

    λ' = max(0, λ + w δ),  at the surface if λ' > 0, released from λ if not,

and in the tangent plane the same with the sliding distance, at most μ λ' (Coulomb's law). Both are displacements,
forces times h²; w is the ratio of the effective mass of all that such forces on the strand move to the particle's: with
H of the iterations and χ = 1 at particles with forces, 1 / w = H⁻¹ M χ. That bounds the row sums of the response to the
forces, so all are updated at once without overshoot. At rest δ = 0, and the force is the same at each step. Depth from
velocity alone, an impact, gives no force that is kept. Curled strands go on giving way for many steps, so that of δ
only the share `Contact.gain` counts.
"""

from __future__ import annotations

from ...constants import W
from ...jit import inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, store, store3, where
from .contact_circle import STEEP, contact_circle, intersection_of_circles, perpendicular
from .contact_place import CARRIED, CENTRE, ROUND, SIZE
from .contact_search import PARTICLE, STARTS, direction, segment_depth
from .contact_shapes import TINY, edges_of, nearest
from .rod_scratch import (
    CONTACT_CHANGE,
    CONTACT_FORCE,
    CORRECTION,
    EDGE,
    IMPACT,
    INVERSE_LENGTH,
    MOBILITY,
    PACK,
    REACH,
)
from .vectors import add_scaled, dot, select

SLACK = 1e-6
"""Depth, as a share of an edge, that counts as rounding; far from the origin, that of coordinates is greater."""
ROUNDS = 3
"""Rotations out of overlapping solids; twice as many if whole edges are kept out, and then as many of the end alone."""
DEEP = 0.05
"""Depth of a segment, as a share of its length, above which other directions are tried. An edge across a corner rests
up to some hundredths deep; other directions there would move it at every step."""
UNBOUND = 1e18
"""Limit of d·axis before any solid has rotated an edge."""
LEAST_MOBILITY = 1e-6
"""Lower bound of a particle's mobility as a share of its own."""


@inlined
def rotate_end_out(s, segment, q, d, positions, contact):
    """Return the unit edge d from q, rotated until its end is outside of all solids: one after the other rotates it,
    the deepest first."""
    # apart from `rotate_whole_out`: with what that keeps from round to round, a step takes 6 % longer
    length, slack = segment.length, slack_of(segment, q, contact)
    at = positions, segment.position
    for _ in range(ROUNDS):
        edges = edges_of(s, segment.scratch, d, length, False, segment.first)
        depth, found = nearest(s, add_scaled(q, length, d), edges, at, -slack, contact.solids)
        inside = depth > slack
        if not any_lane(inside):
            break
        axis, inverse, share, square = contact_circle(s, found, q, load(s, INVERSE_LENGTH))
        turned = add_scaled(perpendicular(d, axis, inverse, square), share, axis)
        d = select(inside, turned, d)
        if not any_lane(inside & (square > 0.0)):  # without a circle, an edge is as far out as it can be
            break
    return d


@inlined
def slack_of(segment, q, contact):
    """Return the depth of an edge's end, metres, that counts as rounding; q: where the edge begins."""
    # without slack, the rounding of its beginning would rotate a short edge at every step
    return max(SLACK * segment.length, contact.rounding * (abs(q[0]) + abs(q[1]) + abs(q[2])))


@inlined
def rotate_whole_out(s, segment, q, d, positions, contact):
    """Return the unit edge d from q, rotated until its end and as much of it as possible is outside of all solids.

    Rotations may alternate between two solids without end. So an edge that would be rotated back into the previous
    solid is set to the intersection of the two circles, and then its end alone is rotated out: particles have priority
    over segments. If an end, or more than `DEEP` of the segment, is still inside, other starting directions are
    tried."""
    length, slack = segment.length, slack_of(segment, q, contact)
    enough = DEEP * length
    at = positions, segment.position
    zero = broadcast(length, 0.0)
    last, last_inverse, limit = (zero, zero, zero), zero, broadcast(length, UNBOUND)
    with_edges, left, start = True, 2 * ROUNDS, 0
    begin, best, least = d, d, broadcast(length, UNBOUND)
    for _ in range((STARTS + 1) * (3 * ROUNDS + 2)):
        edges = edges_of(s, segment.scratch, d, length, with_edges, segment.first)
        depth, found = nearest(s, add_scaled(q, length, d), edges, at, -slack, contact.solids)
        inside = depth > slack
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
        left -= 1
        axis, inverse, share, square = contact_circle(s, found, q, load(s, INVERSE_LENGTH))
        turned = add_scaled(perpendicular(d, axis, inverse, square), share, axis)
        bound = share / inverse
        back = inside & (dot(turned, last) > limit)
        if any_lane(back):
            crossing, there = intersection_of_circles(d, last, last_inverse, limit, axis, inverse, bound)
            turned = select(back & there, crossing, turned)
        last, last_inverse = select(inside, axis, last), where(inside, inverse, last_inverse)
        limit = where(inside, bound, limit)
        d = select(inside, turned, d)
        if not any_lane(inside & (square > 0.0)):  # without a circle, an edge is as far out as it can be
            left = 0
    return best


@inlined
def resolve_contact(s, segment, q, state, contact, pressed):
    """Rotate the unit edge of a segment from q out of all solids, update the contact force on its particle, and add the
    particle's displacement to `CORRECTION`. pressed: whether any lane has forces from the step before."""
    length, push = segment.length, state.push
    d = load3(s, segment.scratch + EDGE, 1)
    end = add_scaled(q, length, d)
    zero = broadcast(length, 0.0)
    reach, mobility, held = zero, broadcast(length, 1.0), (zero, zero, zero)
    if pressed:
        reach, mobility, held = held_displacement(s, segment, push, load(s, REACH))
    was = reach > 0.0
    edges = edges_of(s, segment.scratch, d, length, contact.segments, segment.first)
    depth, found = nearest(s, end, edges, (state.positions, segment.position, True), reach, contact.solids)
    if not any_lane((depth > -reach) | was):
        return
    inverse_length = load(s, INVERSE_LENGTH)
    n = normal_at(s, found, end, depth)
    force = max(dot(held, n), 0.0) + contact.gain * depth
    near = (depth > -reach) & (force > 0.0)
    free = was & ~near
    turned = d
    if any_lane(free):
        turned = select(free, released(d, inverse_length, held), d)
    if any_lane(near):
        axis, inverse, share, square = contact_circle(s, found, q, inverse_length)
        # tangential part of the displacement by the force of the step before
        held = add_scaled(held, -dot(held, n), n)
        kept = friction(held, slide(s, found, end, d, n, depth), n, contact.friction * force)
        p = add_scaled(d, inverse_length, add_scaled(kept, -1.0, held))
        p = perpendicular(p, axis, inverse, square)
        turned = select(near, add_scaled(p, share, axis), turned)
        kept = add_scaled(kept, force, n)
        # an edge that cannot end at the surface is only rotated: its depth does not determine a force
        f = where(square > 0.0, 1.0 / (load(s, REACH) * mobility), 0.0)
        new = near & ~was
        if any_lane(new):
            resting = resting_depth(s, found, segment, state, n, depth, contact.duration)
            f = where(new, f * resting / max(depth, TINY), f)
            store(s, IMPACT, load(s, IMPACT) + where(new, broadcast(f, 1.0), 0.0))
        set_push(s, push, segment.row, select(near, (f * kept[0], f * kept[1], f * kept[2]), (zero, zero, zero)))
    else:
        set_push(s, push, segment.row, (zero, zero, zero))
    if contact.segments:
        turned = rotate_whole_out(s, segment, q, turned, state.positions, contact)
    else:
        turned = rotate_end_out(s, segment, q, turned, state.positions, contact)
    store3(s, segment.scratch + EDGE, 1, turned[0], turned[1], turned[2])
    x, y, z = load3(s, CORRECTION, 1)
    store3(s, CORRECTION, 1, x + turned[0] - d[0], y + turned[1] - d[1], z + turned[2] - d[2])


@inlined
def set_push(s, push, row, force):
    """Set the force of contact on a particle, an acceleration, and add it and its change to the sums of the strand."""
    ax, ay, az = force
    bx, by, bz = load3(push, row, PACK)
    store(s, CONTACT_FORCE, load(s, CONTACT_FORCE) + (abs(ax) + abs(ay) + abs(az)))
    store(s, CONTACT_CHANGE, load(s, CONTACT_CHANGE) + (abs(ax - bx) + abs(ay - by) + abs(az - bz)))
    store3(push, row, PACK, ax, ay, az)


@inlined
def held_displacement(s, segment, push, reach):
    """Return the effect of the step before's force on a particle: an upper bound of the displacement's length, 0
    without a force; the particle's mobility, 1 / w, as a share of its own; and the displacement. reach: displacement of
    a free particle by 1 m/s², metres."""
    ax, ay, az = load3(push, segment.row, PACK)
    size = abs(ax) + abs(ay) + abs(az)
    # `MOBILITY` of a particle without a force is only the response to forces on others
    mobility = where(size > 0.0, load(s, segment.scratch + MOBILITY), 0.0)
    mobility = where(mobility > 0.0, min(max(mobility, LEAST_MOBILITY), 1.0), 1.0)
    f = reach * mobility
    return size * f, mobility, (f * ax, f * ay, f * az)


@inlined
def normal_at(s, found, end, depth):
    """Return the unit normal of the solid in slot ``found`` at a particle ``depth`` below its surface."""
    round = load(s, found + ROUND) > 0.0
    centre = load3(s, found + CENTRE, 1)
    x, y, z = end[0] - centre[0], end[1] - centre[1], end[2] - centre[2]
    away = load(s, found + SIZE) - depth
    deep = round & (depth > away)
    if any_lane(deep):  # near the centre, the radius less the depth cancels
        away = where(deep, sqrt(x * x + y * y + z * z), away)
    away = 1.0 / max(away, TINY)
    return select(round, (away * x, away * y, away * z), centre)


@inlined
def released(d, inverse_length, held):
    """Return the unit edge d without the displacement ``held`` of its end."""
    e = add_scaled(d, -inverse_length, held)
    f = 1.0 / sqrt(max(dot(e, e), TINY))
    return f * e[0], f * e[1], f * e[2]


@inlined
def slide(s, found, end, d, n, depth):
    """Return the vector by which a particle slides on the solid in slot ``found`` in this step: from its position moved
    with the solid to the point where the edge, rotated, ends at the surface."""
    f = dot(d, n)
    turned = f * (depth / max(1.0 - f * f, STEEP))
    carried = load3(s, found + CARRIED, 1)
    return add_scaled((end[0] - carried[0], end[1] - carried[1], end[2] - carried[2]), -turned, d)


@inlined
def friction(held, way, n, most):
    """Return the tangential displacement by friction: ``held``, from the step before, less the ``way`` that the
    particle slides, of a length of at most ``most`` (Coulomb's law); n: normal."""
    kept = add_scaled(add_scaled(held, -1.0, way), dot(way, n), n)
    f = min(sqrt(most * most / max(dot(kept, kept), TINY)), 1.0)
    return f * kept[0], f * kept[1], f * kept[2]


@inlined
def resting_depth(s, found, segment, state, n, depth, duration):
    """Return the part of the depth of a particle in new contact that its velocity before the step does not account for;
    the rest is an impact and gives no lasting force."""
    v = load3(state.velocity, segment.row, PACK)
    before = load3(state.positions, segment.position, W)
    carried = load3(s, found + CARRIED, 1)
    way = carried[0] - before[0], carried[1] - before[1], carried[2] - before[2]
    fall = dot(n, way) - duration * dot(n, v)
    return max(depth - max(fall, 0.0), 0.0)
