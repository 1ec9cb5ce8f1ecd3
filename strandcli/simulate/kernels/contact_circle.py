"""The circle on which an edge ends at the surface of a solid, and how an edge is taken to it."""

from __future__ import annotations

from ...jit import inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, where
from .contact_place import CENTRE, ROUND, SIZE
from .contact_shapes import LEAST, TINY
from .vectors import add_scaled, dot, select

STEEP = 0.01
"""Square of an edge's share across an axis below which what rounding adds along the axis is taken out."""


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
