"""The circle of directions in which an edge ends at the surface of a solid, and projection of an edge onto it."""

from __future__ import annotations

from ...jit import inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, where
from .contact_place import CENTRE, ROUND, SIZE
from .contact_shapes import LEAST, TINY
from .vectors import add_scaled, dot, select

STEEP = 0.01
"""Squared component of an edge perpendicular to an axis below which it is made orthogonal a second time, because of
rounding."""


@inlined
def contact_circle(s, found, q, inverse_length):
    """Return the circle on which an edge of length 1 from q ends at the surface of the solid in slot ``found``: its
    axis, toward a ball's centre or against a face's normal; 1 / |axis|²; the position of the circle's centre along the
    axis, as a share; its squared radius. Without an intersection, the nearest point, with a squared radius of at most
    0."""
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
    if any_lane(beyond):  # the share may overflow; at a ball's centre every direction is equal
        least = sqrt(inverse)
        share = where(beyond, where(share > 0.0, least, -least), share)
        high = where(beyond, where(square > TINY, broadcast(high, 1.0), 0.0), high)
    return axis, inverse, share, 1.0 - high


@inlined
def perpendicular(d, axis, inverse, square):
    """Return the component of d perpendicular to an axis, scaled to the squared length ``square``; inverse: 1 /
    |axis|²."""
    p = add_scaled(d, -(dot(d, axis) * inverse), axis)
    left = dot(p, p)
    steep = left < STEEP
    if any_lane(steep):
        p = select(steep, add_scaled(p, -(dot(p, axis) * inverse), axis), p)
        left = dot(p, p)
        lost = left < LEAST * LEAST
        if any_lane(lost):  # d is parallel to the axis: any perpendicular direction will do
            one = where(axis[0] * axis[0] * inverse > 0.25, broadcast(left, 0.0), 1.0)
            two = 1.0 - one
            f = (one * axis[0] + two * axis[1]) * inverse
            p = select(lost, (one - f * axis[0], two - f * axis[1], -f * axis[2]), p)
            left = dot(p, p)
    f = sqrt(square / max(left, TINY))
    return f * p[0], f * p[1], f * p[2]


@inlined
def intersection_of_circles(d, one, one_inverse, one_limit, two, two_inverse, two_limit):
    """Return the unit vector x nearest to d with x·one = one_limit and x·two = two_limit, and whether there is one.

    x = α one + β two ± γ one × two, where α and β solve the two equations and γ follows from the length; one_inverse,
    two_inverse: 1 over the squared axes."""
    share = dot(one, two) * one_inverse
    # component of the second axis perpendicular to the first
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
