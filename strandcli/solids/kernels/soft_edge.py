"""How near a light is to the edge of solids by their signed distance: the angle that soft shadows follow from.

`distance_in_own(p, m, u, v, w)` is that of a written module (`strandcli.solids.shapes.other_code`): the distance of a
point of the frame of solid m; `distances_in_own` takes vectors of `strandcli.simd`. The rest is as in `distance_field`.
"""

from __future__ import annotations

import numpy as np

from ...jit import inlined
from ...simd import any_lane, where
from ..shapes.other import REACH, X, Y, Z
from .distance_field import HALF, ONE, number, own, own_direction

ACROSS = 64
"""Parts of the way through a solid's ball that a search for its edge looks at, at the least."""
FINE_ACROSS = 256
"""The same for shapes with data, which have more detail."""
CLEAR = np.float32(2.0)
"""More than any sine."""


@inlined
def least_sine(distance_in_own, parts, p, m, x, y, z, way, light):
    """Sine of the least angle between a unit vector and the edge of solid m, less `skin`, as seen from a point: the
    least of its distance over the distance travelled.

    light: the distance to the light, the sine of its angular radius, and `skin`. Steps are half the distance from the
    solid, or as far as the cone about the light is certainly free of it, and at least a share 1 / ``parts`` of the way
    through the solid's ball. What is below minus the radius is some such sine, and what is above it, too: all of the
    light is hidden, or none."""
    lx, ly, lz = way
    reach, radius, skin = light
    cx = number(p, m, X) - x
    cy = number(p, m, Y) - y
    cz = number(p, m, Z) - z
    middle = cx * lx + cy * ly + cz * lz
    end = min(middle + number(p, m, REACH), reach)
    step = (number(p, m, REACH) + number(p, m, REACH)) / np.float32(parts)
    t = max(middle - number(p, m, REACH), HALF * step)
    least = CLEAR
    per = ONE / (ONE + radius)
    u, v, w = own(p, m, x, y, z)
    du, dv, dw = own_direction(p, m, lx, ly, lz)
    while t < end and least > -radius:
        away = distance_in_own(p, m, u + t * du, v + t * dv, w + t * dw) + skin
        least = min(least, away / t)
        t += max(max(abs(away) * HALF, step), (away - radius * t) * per)
    return least


@inlined
def least_sine_of_all(distance_in_own, parts, p, x, y, z, way, light):
    """`least_sine` of all of these solids, until one hides all of the light."""
    least = CLEAR
    for m in range(p.rows.shape[0]):
        if least > -light[1]:
            least = min(least, least_sine(distance_in_own, parts, p, m, x, y, z, way, light))
    return least


@inlined
def least_sines(distances_in_own, parts, p, m, least, point, way, light):
    """`least_sine` of vectors, and not more than ``least``: below minus the radius there is nothing to look for."""
    x, y, z = point
    lx, ly, lz = way
    reach, radius, skin = light
    middle = (number(p, m, X) - x) * lx + (number(p, m, Y) - y) * ly + (number(p, m, Z) - z) * lz
    end = min(middle + number(p, m, REACH), reach)
    step = (number(p, m, REACH) + number(p, m, REACH)) / np.float32(parts)
    t = max(middle - number(p, m, REACH), HALF * step)
    per = ONE / (radius + ONE)
    u, v, w = own(p, m, x, y, z)
    du, dv, dw = own_direction(p, m, lx, ly, lz)
    while True:
        on = (t < end) & (least > -radius)
        if not any_lane(on):
            return least
        away = distances_in_own(p, m, u + t * du, v + t * dv, w + t * dw) + skin
        least = where(on, min(least, away / t), least)
        t = where(on, t + max(max(abs(away) * HALF, step), (away - radius * t) * per), t)


@inlined
def least_sines_of_all(distances_in_own, parts, p, least, point, way, light):
    """`least_sines` of all of these solids."""
    for m in range(p.rows.shape[0]):
        least = least_sines(distances_in_own, parts, p, m, least, point, way, light)
    return least
