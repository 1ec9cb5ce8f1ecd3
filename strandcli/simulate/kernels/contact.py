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
from .contact_place import CARRIED, CENTRE, ROUND, SIZE
from .contact_shapes import LEAST, TINY, edges_of, nearest
from .rod_scratch import CONTACT_FORCE, CORRECTION, EDGE, IMPACT, INVERSE_LENGTH, MOBILITY, PACK
from .vectors import add_scaled, dot, select

SLACK = 1e-6
"""Depth, as a share of an edge, up to which it counts as rounding; far from the origin that of coordinates is more."""
STEEP = 0.01
"""Square of an edge's share across an axis below which what rounding adds along the axis is taken out."""
ROUNDS = 3
"""Turns out of solids that overlap; twice as many where whole edges are kept out, and then as many of the end alone."""
UNBOUND = 1e18
"""Limit of d·axis where no solid has turned an edge yet."""
LEAST_MOBILITY = 1e-6
"""Least share of its own mobility that a particle is taken to have."""


@inlined
def contact_circle(s, found, q, inverse_length):
    """The circle on which an edge of length 1 from q ends at the surface of the solid in slot ``found``: its axis,
    which leads to a ball's centre or straight into a flat face; 1 over the axis's square; where along the axis the
    circle's centre is, as a share; the square of its radius. Where there is no circle, the point nearest to it, with a
    radius of 0 or less."""
    o = load3(s, found + CENTRE, 1)
    size = load(s, found + SIZE)
    round = load(s, found + ROUND) > 0.0
    toward = inverse_length * (o[0] - q[0]), inverse_length * (o[1] - q[1]), inverse_length * (o[2] - q[2])
    axis = select(round, toward, (-o[0], -o[1], -o[2]))
    square = max(dot(axis, axis), TINY)
    inverse = 1.0 / square
    height = inverse_length * (dot(q, o) - size)
    size *= inverse_length
    share = where(round, 0.5 + 0.5 * (square - size * size), height) * inverse
    high = share * share * square
    beyond = high > 1.0
    if any_lane(beyond):  # a share may be more than numbers can tell; at a ball's very centre any direction is as good
        least = sqrt(inverse)
        share = where(beyond, where(share > 0.0, least, -least), share)
        high = where(beyond, where(square > TINY, broadcast(high, 1.0), 0.0), high)
    return axis, inverse, share, 1.0 - high


@inlined
def perpendicular(d, axis, inverse, square):
    """What of d is across an axis, brought to a length whose square is ``square``; ``inverse`` is 1 over |axis|²."""
    p = add_scaled(d, -(dot(d, axis) * inverse), axis)
    left = dot(p, p)
    steep = left < STEEP
    if any_lane(steep):
        p = select(steep, add_scaled(p, -(dot(p, axis) * inverse), axis), p)
        left = dot(p, p)
        lost = left < LEAST * LEAST
        if any_lane(lost):  # d is parallel to the axis: any direction across it will do
            one = where(axis[0] * axis[0] * inverse > 0.25, broadcast(left, 0.0), 1.0)
            two = 1.0 - one
            f = (one * axis[0] + two * axis[1]) * inverse
            p = select(lost, (one - f * axis[0], two - f * axis[1], -f * axis[2]), p)
            left = dot(p, p)
    f = sqrt(square / max(left, TINY))
    return f * p[0], f * p[1], f * p[2]


@inlined
def intersection_of_circles(d, one, one_inverse, one_limit, two, two_inverse, two_limit):
    """The unit vector nearest to d with d·one = one_limit and d·two = two_limit, and whether there is any.

    d = α one + β two ± γ one × two, where α and β solve the two equations and γ is left for the length; `one_inverse`
    and `two_inverse` are 1 over the squares of the two axes."""
    share = dot(one, two) * one_inverse
    # of the second axis what is across the first, and what d has to have along it
    p = add_scaled(two, -share, one)
    square = dot(p, p)
    independent = square * two_inverse > LEAST  # else the axes are parallel
    along_one = one_limit * one_inverse
    along_two = (two_limit - share * one_limit) / max(square, TINY)
    left = 1.0 - along_one * one_limit - along_two * along_two * square
    c = one[1] * p[2] - one[2] * p[1], one[2] * p[0] - one[0] * p[2], one[0] * p[1] - one[1] * p[0]
    size = sqrt(max(left, 0.0) / max(dot(c, c), TINY))
    size = where(dot(d, c) < 0.0, -size, size)
    in_plane = add_scaled((along_one * one[0], along_one * one[1], along_one * one[2]), along_two, p)
    return add_scaled(in_plane, size, c), independent & (left >= 0.0)


@inlined
def turn_out_of_solids(s, segment, q, d, positions, contact):
    """The unit edge d from q, turned until its end is in no solid.

    One solid after the other turns it, the deepest first. Where whole edges are kept out, turns to and fro may never
    end: what one solid asks for, another forbids. So an edge that would be turned back into the solid before goes to
    the intersection of the two circles. Whatever that leaves, the end is turned out alone: no segment is kept out at
    the price of its particle."""
    length, whole = segment.length, contact.segments
    # without slack, short edges would be turned for the rounding of where they begin, again and again
    slack = max(SLACK * length, contact.rounding * (abs(q[0]) + abs(q[1]) + abs(q[2])))
    rounds = 3 * ROUNDS if whole else ROUNDS
    at = positions, segment.position
    zero = broadcast(length, 0.0)
    last, last_inverse, limit = (zero, zero, zero), zero, broadcast(length, UNBOUND)
    end_alone = False  # whether all that is left to do is to turn the end out alone
    best, least = d, broadcast(length, UNBOUND)
    for k in range(rounds):
        with_edges = whole and not end_alone and k < 2 * ROUNDS
        edges = edges_of(s, segment.scratch, d, length, with_edges, segment.first)
        depth, found = nearest(s, add_scaled(q, length, d), edges, at, -slack, contact.solids)
        inside = depth > slack
        if whole and not with_edges:
            best, least = select(depth < least, d, best), min(depth, least)
        if not any_lane(inside) or (whole and k == rounds - 1):
            if not with_edges:
                break
            end_alone = True
            continue
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
            end_alone = True
    if whole:  # overlapping solids may leave no way out: then the direction of the least depth
        d = select(least < UNBOUND, best, d)
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
