"""Contact of rods, edge by edge from root to tip: an edge that leads into a solid is turned until it does not.

The edge keeps its length, so its particle stays on a sphere about the one before it, and what is allowed of that sphere
is where the edge makes at least a certain angle with one axis: c = d·a may be at most some limit. For a ball about o,
with a toward o and D = |o − q|, the particle stays out where c <= (ℓ² + D² − r²) / (2 ℓ D), and for a flat face with
normal −a where c <= (height of q) / ℓ. Where c is the limit the edge ends on a circle about the axis, to which it is
taken straight across the axis. Lengths stay exact and no penalty is involved.

Force. Newton's iterations come before this and would bend a strand that leans on a solid as if nothing were there; what
is left of that after turning edges depends on the step. So the force of contact is kept from step to step, as the
acceleration of the particle that it acts on, and takes part in the iterations (the multiplier of an augmented
Lagrangian, updated once a step: Nocedal & Wright 2006, §17.3). A particle that comes to lie at depth δ, where the force
of the step before came to λ, has

    λ' = max(0, λ + w δ),  held at the surface where λ' > 0, set free from λ where not,

and across the normal the same with the way that it slid, no more than friction times λ' (Coulomb's law). Both are
displacements, forces times h²; w is how much heavier than the particle all is that such forces on the strand move: with
H of the iterations and χ = 1 where there are forces, 1 / w = H⁻¹ M χ, a bound on the row sums of what forces lead to,
so that all may be updated at once without overshoot. At rest δ = 0, and a strand leans on a solid just as it would at
any other step. The depth that comes of velocity alone, an impact, is no force kept.
"""

from __future__ import annotations

from ...constants import W
from ...jit import inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, store, store3, where
from .contact_shapes import LEAST, TINY, nearest
from .rod import GRIP, HIT, OFF, OVER, PACK, E, R

SLACK = 1e-6
"""Depth as a share of an edge that is no more than rounding, where that of coordinates is not more yet."""
STEEP = 0.01
"""Share of an edge across an axis, squared, below which rounding along the axis is to be taken out of it."""
ROUNDS = 3
"""Turns off solids that overlap; twice as many where whole edges are kept out, and then as many of the end alone."""
UNBOUND = 1e18
"""Limit of d·axis where no solid has turned an edge yet."""
LIGHTEST = 1e-6
"""Share of a particle's own mobility that is never undercut."""


@inlined
def dot(a, b):
    """Product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def along(a, f, b):
    """a + f b."""
    return a[0] + f * b[0], a[1] + f * b[1], a[2] + f * b[2]


@inlined
def select(mask, a, b):
    """Three vectors: of a where a mask holds."""
    return where(mask, a[0], b[0]), where(mask, a[1], b[1]), where(mask, a[2], b[2])


@inlined
def circle(s, found, q, over):
    """The circle on which an edge from q ends at the surface that was found, its length being 1: the axis, which leads
    to a ball's centre or straight into a flat face, and 1 over its square; how far along it the circle's centre is, as
    a share; the square of the radius. Where there is none, the end that is nearest to it."""
    o = load3(s, found, 1)
    size = load(s, found + 3)
    round = load(s, found + 7) > 0.0
    axis = select(round, (over * (o[0] - q[0]), over * (o[1] - q[1]), over * (o[2] - q[2])), (-o[0], -o[1], -o[2]))
    square = max(dot(axis, axis), TINY)
    inverse = 1.0 / square
    height = over * (dot(q, o) - size)
    size *= over
    share = where(round, 0.5 + 0.5 * (square - size * size), height) * inverse
    high = share * share * square
    beyond = high > 1.0
    if any_lane(beyond):  # however far, even more than numbers can tell; from a ball's very centre, any way is as near
        least = sqrt(inverse)
        share = where(beyond, where(share > 0.0, least, -least), share)
        high = where(beyond, where(square > TINY, broadcast(high, 1.0), 0.0), high)
    return axis, inverse, share, 1.0 - high


@inlined
def across(d, axis, inverse, square):
    """What of a vector is across an axis, ``inverse`` being 1 over that one's square, brought to a length with that
    ``square``."""
    p = along(d, -(dot(d, axis) * inverse), axis)
    left = dot(p, p)
    steep = left < STEEP
    if any_lane(steep):
        p = select(steep, along(p, -(dot(p, axis) * inverse), axis), p)
        left = dot(p, p)
        lost = left < LEAST * LEAST
        if any_lane(lost):  # straight at it: any way round will do
            one = where(axis[0] * axis[0] * inverse > 0.25, broadcast(left, 0.0), 1.0)
            two = 1.0 - one
            f = (one * axis[0] + two * axis[1]) * inverse
            p = select(lost, (one - f * axis[0], two - f * axis[1], -f * axis[2]), p)
            left = dot(p, p)
    f = sqrt(square / max(left, TINY))
    return f * p[0], f * p[1], f * p[2]


@inlined
def both(d, one, one_inverse, one_limit, two, two_inverse, two_limit):
    """The unit vector nearest to d that makes d·one = one_limit and d·two = two_limit, and whether there is any.

    d = α one + β two ± γ one × two, where α and β solve the two equations and γ is left for the length; `one_inverse`
    and `two_inverse` are 1 over the squares of the two axes."""
    share = dot(one, two) * one_inverse
    # of the second axis what is across the first, and what d has to have along it
    p = along(two, -share, one)
    square = dot(p, p)
    steep = square * two_inverse > LEAST  # else the axes are parallel
    along_one = one_limit * one_inverse
    along_two = (two_limit - share * one_limit) / max(square, TINY)
    left = 1.0 - along_one * one_limit - along_two * along_two * square
    c = one[1] * p[2] - one[2] * p[1], one[2] * p[0] - one[0] * p[2], one[0] * p[1] - one[1] * p[0]
    size = sqrt(max(left, 0.0) / max(dot(c, c), TINY))
    size = where(dot(d, c) < 0.0, -size, size)
    return along(along((along_one * one[0], along_one * one[1], along_one * one[2]), along_two, p), size, c), (
        steep & (left >= 0.0)
    )


@inlined
def off_solids(s, segment, q, d, positions, contact):
    """Turn an edge from q along d off every solid that its end is in.

    One solid after the other turns it, the deepest first. Where the edge itself is to be kept out, turns to and fro may
    never end: what one solid asks for, another often forbids. So an edge that would be turned back into the solid
    before goes to where the two circles cross. Whatever that leaves, the end is turned out alone: no segment is kept
    out at the price of its particle."""
    # without slack, short edges would be turned for the rounding of where they begin, again and again
    o, length, whole = segment.scratch, segment.length, contact.segments
    slack = max(SLACK * length, contact.rounding * (abs(q[0]) + abs(q[1]) + abs(q[2])))
    rounds = 3 * ROUNDS if whole else ROUNDS
    zero = broadcast(length, 0.0)
    last, last_inverse, limit = (zero, zero, zero), zero, broadcast(length, UNBOUND)
    settled = False  # whether all that is left to do is to turn the end out alone
    best, least = d, broadcast(length, UNBOUND)
    for k in range(rounds):
        edges = whole and not settled and k < 2 * ROUNDS
        x, y, z = along(q, length, d)
        depth, found = nearest(
            s, o, (x, y, z), d, length, (positions, segment.position), -slack, contact.solids, edges, segment.first
        )
        inside = depth > slack
        if whole and not edges:
            best, least = select(depth < least, d, best), min(depth, least)
        if not any_lane(inside) or (whole and k == rounds - 1):
            if not edges:
                break
            settled = True
            continue
        axis, inverse, share, square = circle(s, found, q, load(s, OVER))
        turned = along(across(d, axis, inverse, square), share, axis)
        if whole:
            bound = share / inverse
            back = inside & (dot(turned, last) > limit)
            if any_lane(back):
                crossing, there = both(d, last, last_inverse, limit, axis, inverse, bound)
                turned = select(back & there, crossing, turned)
            last, last_inverse = select(inside, axis, last), where(inside, inverse, last_inverse)
            limit = where(inside, bound, limit)
        d = select(inside, turned, d)
        if not any_lane(inside & (square > 0.0)):  # those from too deep inside are as far out as they get
            if not whole:
                break
            settled = True
    if whole:  # overlapping solids may leave no way out: then the one that is least deep
        d = select(least < UNBOUND, best, d)
    return d


@inlined
def touch(s, segment, q, state, contact, pressed):
    """Turn the unit edge of a segment that begins at q off all solids, update the force on its particle, and add the
    particle's displacement to OFF; ``pressed``: whether there is any force of the step before."""
    o, row, here, length, push = segment.scratch, segment.row, segment.position, segment.length, state.push
    d = load3(s, o + E, 1)
    x, y, z = along(q, length, d)
    none = broadcast(length, 0.0)
    grip, light, held = none, broadcast(length, 1.0), (none, none, none)
    if pressed:
        ax, ay, az = load3(push, row, PACK)
        grip = abs(ax) + abs(ay) + abs(az)
        # of particles that nothing pressed R tells only how far others' forces take them
        light = where(grip > 0.0, load(s, o + R), 0.0)
        light = where(light > 0.0, min(max(light, LIGHTEST), 1.0), 1.0)
        f = contact.reach * light
        grip *= f  # at least as far as it puts the particle off
        held = f * ax, f * ay, f * az
    was = grip > 0.0
    depth, found = nearest(
        s, o, (x, y, z), d, length, (state.positions, here), grip, contact.solids, contact.segments, segment.first
    )
    if not any_lane((depth > -grip) | was):
        return
    over = load(s, OVER)
    round = load(s, found + 7) > 0.0
    centre = load3(s, found, 1)
    n = x - centre[0], y - centre[1], z - centre[2]
    away = load(s, found + 3) - depth
    deep = round & (depth > away)
    if any_lane(deep):  # a great ball's radius leaves nothing of a small distance
        away = where(deep, sqrt(dot(n, n)), away)
    away = 1.0 / max(away, TINY)
    n = select(round, (away * n[0], away * n[1], away * n[2]), centre)
    force = max(dot(held, n), 0.0) + depth
    near = (depth > -grip) & (force > 0.0)
    free = was & ~near
    turned = d
    if any_lane(free):
        e = along(d, -over, held)
        f = 1.0 / sqrt(max(dot(e, e), TINY))
        turned = select(free, (f * e[0], f * e[1], f * e[2]), d)
    if any_lane(near):
        axis, inverse, share, square = circle(s, found, q, over)
        # friction: what holds the particle across the normal, less the way that it slides there, f d of it by turning
        # the edge so that it comes to lie on the surface
        held = along(held, -dot(held, n), n)
        f = dot(d, n)
        f *= depth / max(1.0 - f * f, STEEP)
        way = along((x - load(s, found + 4), y - load(s, found + 5), z - load(s, found + 6)), -f, d)
        kept = along(along(held, -1.0, way), dot(way, n), n)
        most = contact.friction * force
        f = min(sqrt(most * most / max(dot(kept, kept), TINY)), 1.0)
        kept = f * kept[0], f * kept[1], f * kept[2]
        p = across(along(d, over, along(kept, -1.0, held)), axis, inverse, square)
        turned = select(near, along(p, share, axis), turned)
        kept = along(kept, force, n)
        # an edge too deep inside to end at the surface is only turned: no force of its depth would be the right one
        f = where(square > 0.0, 1.0 / (contact.reach * light), 0.0)
        new = near & ~was
        if any_lane(new):
            # an impact is no force that stays: of the depth, what velocity alone has led to
            vx, vy, vz = load3(state.velocity, row, PACK)
            ax, ay, az = load3(state.positions, here, W)
            fall = dot(n, (load(s, found + 4) - ax, load(s, found + 5) - ay, load(s, found + 6) - az))
            fall -= contact.duration * dot(n, (vx, vy, vz))
            f = where(new, f * max(depth - max(fall, 0.0), 0.0) / max(depth, TINY), f)
            store(s, HIT, load(s, HIT) + where(new, broadcast(f, 1.0), 0.0))
        ax, ay, az = select(near, (f * kept[0], f * kept[1], f * kept[2]), (none, none, none))
        store3(push, row, PACK, ax, ay, az)
        store(s, GRIP, load(s, GRIP) + (abs(ax) + abs(ay) + abs(az)))
    else:
        store3(push, row, PACK, 0.0, 0.0, 0.0)
    turned = off_solids(s, segment, q, turned, state.positions, contact)
    store3(s, o + E, 1, turned[0], turned[1], turned[2])
    ax, ay, az = load3(s, OFF, 1)
    store3(s, OFF, 1, ax + turned[0] - d[0], ay + turned[1] - d[1], az + turned[2] - d[2])
