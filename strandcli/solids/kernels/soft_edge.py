"""How near a light is to the edge of solids by their signed distance: the angle that soft shadows follow from.

p and m are as in `distance_field`.
"""

from __future__ import annotations

import numpy as np

from ...jit import inlined
from ...simd import any_lane, where
from ..custom import REACH, X, Y, Z
from .distance_field import (
    HALF,
    INF,
    ONE,
    ZERO,
    bounds,
    distances_in_own,
    number,
    own,
    own_direction,
)  # fmt: skip

ACROSS = 64
"""Parts of the path through a solid's ball that a search for its edge looks at, at the least."""
FINE_ACROSS = 256
"""The same for shapes with data, which have more detail."""
CLEAR = np.float32(2.0)
"""More than any sine."""
SLOW = np.float32(1e-3)
"""How fast, metres a metre, a cone must leave a face at the least: slower, rounding would tell where."""


@inlined
def free_from(box, point, direction, radius):
    """How far along unit vectors the cones of light about them, ``radius`` the sines of their half angles, are free of
    a solid within a `box` from there on: past a face, and going away from it faster than they widen."""
    u, v, w = point
    du, dv, dw = direction
    x = past_face(box[0], box[3], u, du, radius)
    y = past_face(box[1], box[4], v, dv, radius)
    return min(min(x, y), past_face(box[2], box[5], w, dw, radius))


@inlined
def past_face(low, high, at, along, radius):
    """The same, past the face across an axis that is ahead; at, along: coordinates of the point and of the vector."""
    ahead = where(along > ZERO, high - at, at - low)
    apart = abs(along) - radius
    return where(apart > SLOW, ahead / apart, INF)


@inlined
def begin(parts, p, m, point, direction, light):
    """Of vectors of rays, in the frame of solid m: where they begin and their directions, six numbers; and the first
    and the last place of `walk`, where the cones have left the solid's `bounds` for good."""
    x, y, z = point
    lx, ly, lz = direction
    reach, radius, _ = light
    middle = (number(p, m, X) - x) * lx + (number(p, m, Y) - y) * ly + (number(p, m, Z) - z) * lz
    u, v, w = own(p, m, x, y, z)
    du, dv, dw = own_direction(p, m, lx, ly, lz)
    t = max(middle - number(p, m, REACH), HALF * step_of(p, m, parts))
    free = free_from(bounds(p, m), (u, v, w), (du, dv, dw), radius)
    return (u, v, w, du, dv, dw), t, min(min(middle + number(p, m, REACH), reach), free)


@inlined
def walk(parts, p, m, some, rest):
    """Return the sines of the least angles between rays and the edge of solid m, less `skin`: the least of its distance
    over the distance travelled. What is below minus the light's radius is some such sine, and what is above it, too:
    all of the light is hidden, or none.

    Two vectors of rays go at once, as each step waits for the one before. Of each: `begin`'s first three; the least
    sine so far, below minus the radius of which there is nothing to look for; and the light: its distance, the sine of
    its angular radius, and `skin`. Steps are half the distance from the solid, or as far as the cone about the light is
    certainly free of it, and at least a share 1 / ``parts`` of the path through the solid's ball."""
    one, s, s_end, s_least, s_light = some
    two, t, t_end, t_least, t_light = rest
    step = step_of(p, m, parts)
    while True:
        s_on = (s < s_end) & (s_least > -s_light[1])
        t_on = (t < t_end) & (t_least > -t_light[1])
        if not any_lane(s_on | t_on):
            return s_least, t_least
        s_away = away_at(p, m, one, s) + s_light[2]
        t_away = away_at(p, m, two, t) + t_light[2]
        s_least = where(s_on, min(s_least, s_away / s), s_least)
        t_least = where(t_on, min(t_least, t_away / t), t_least)
        s = where(s_on, s + pace(s_away, s, step, s_light[1]), s)
        t = where(t_on, t + pace(t_away, t, step, t_light[1]), t)


@inlined
def away_at(p, m, along, t):
    """The distances at places of rays."""
    u, v, w, du, dv, dw = along
    return distances_in_own(p, m, u + t * du, v + t * dv, w + t * dw)


@inlined
def pace(away, t, step, radius):
    """How far rays go on from a place where the solid is so far away, as in `walk`."""
    return max(max(abs(away) * HALF, step), (away - radius * t) * (ONE / (radius + ONE)))


@inlined
def step_of(p, m, parts):
    """The least step through solid m, metres."""
    return (number(p, m, REACH) + number(p, m, REACH)) / np.float32(parts)
