"""Contact of rods, edge by edge from root to tip: an edge whose end is in a solid is rotated until it is outside.

The edge keeps its length, so its particle stays on a sphere around the one before it. The solid allows the directions d
for which d·a <= c, where a is an axis. For a ball of radius r about o, with a unit vector a toward o and D = |o − q|, c
= (ℓ² + D² − r²) / (2 ℓ D); for a flat face with the normal −a, c = (height of q above it) / ℓ. If it is violated, the
edge is projected onto the circle d·a = c, perpendicularly to the axis. Lengths stay exact, and there is no penalty
term. What is left to rotate is what the forces of contact (`contact_forces`) have not held back.
"""

from __future__ import annotations

from ...jit import inlined
from ...simd import any_lane, broadcast, load, load3, store3, where
from .contact_circle import contact_circle, intersection_of_circles, perpendicular
from .contact_search import PARTICLE, STARTS, direction, segment_depth
from .contact_shapes import edges_of, nearest
from .rod_scratch import CORRECTION, EDGE, INVERSE_LENGTH
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
CLEAR = 0.01
"""Distance from solids, as a share of an edge, from which on no edge is tested at the end of a step."""


@inlined
def rotate_end_out(s, segment, q, d, positions, contact):
    """Return the unit edge d from q, rotated until its end is outside of all solids: one after the other rotates it,
    the deepest first."""
    # apart from `rotate_whole_out`: with what that keeps from round to round, a step takes 6 % longer
    length, slack = segment.length, slack_of(segment.length, q, contact)
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
def slack_of(length, q, contact):
    """Return the depth of the end of an edge of a length, metres, that counts as rounding; q: where it begins."""
    # without slack, the rounding of its beginning would rotate a short edge at every step
    return max(SLACK * length, contact.rounding * (abs(q[0]) + abs(q[1]) + abs(q[2])))


@inlined
def rotate_whole_out(s, segment, q, d, positions, contact):
    """Return the unit edge d from q, rotated until its end and as much of it as possible is outside of all solids.

    Rotations may alternate between two solids without end. So an edge that would be rotated back into the previous
    solid is set to the intersection of the two circles, and then its end alone is rotated out: particles have priority
    over segments. If an end, or more than `DEEP` of the segment, is still inside, other starting directions are
    tried."""
    length, slack = segment.length, slack_of(segment.length, q, contact)
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
def keep_out(s, segment, q, positions, contact):
    """Rotate the unit edge of a segment from q out of all solids, and add its particle's displacement to
    `CORRECTION`."""
    d = load3(s, segment.scratch + EDGE, 1)
    if contact.segments:
        turned = rotate_whole_out(s, segment, q, d, positions, contact)
    else:
        turned = rotate_end_out(s, segment, q, d, positions, contact)
    store3(s, segment.scratch + EDGE, 1, turned[0], turned[1], turned[2])
    x, y, z = load3(s, CORRECTION, 1)
    store3(s, CORRECTION, 1, x + turned[0] - d[0], y + turned[1] - d[1], z + turned[2] - d[2])
