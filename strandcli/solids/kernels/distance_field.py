"""Custom solids by their signed distance, in kernels: rays, normals, shadows and contact.

p holds the packed solids, `rows`, and the arrays that their shapes have besides (`strandcli.solids.custom`); m tells
one of them. Where rows are an array, m is the number of a row, in kernels of rods, where they are numbers at an
address, the place where a row begins. `distance`, `normal`, `meet`, `hides` are functions of the class of p
(`compose`): those of a shape where it has them, else `march`, `gradient` and `hides_by_distance`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import types

from ...jit import device
from ...jit.pruned import by_type
from ..custom import REACH, ROW_X, ROW_Y, ROW_Z, X, Y, Z

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
INF = np.float32(np.inf)
TINY = np.float32(1e-20)
STEPS = 256
"""Of a ray, at the most."""
NEAR = np.float32(1e-4)
"""Share of a solid's reach within which a ray has met its surface."""
FINE = np.float32(1e-3)
"""Half the distance over which a gradient is measured, as a share of the reach."""
ROUNDS = 4
"""Steps of a point or a segment on its way out, at the most: one is enough for an exact distance or a flat face."""
OUT = np.float32(1e-6)
"""Depth, as a share of a solid's reach, from which on a point is not moved any more: ten times the rounding."""


def of_class(name: str, inline: bool = False) -> Any:
    """A function of custom solids: kernels that call it call that of this name that the class of p has."""

    def choose(p: Any, *rest: Any) -> Any:
        return getattr(p.instance_class, name)

    return by_type(choose, inline, strict=False)


distance_in_own, normal, meet, hides = map(of_class, ("distance_in_own", "normal", "meet", "hides"))
"""(p, m, u, v, w): distance of a point, in the frame of solid m. (p, m, x, y, z): unit outward normal where the surface
is nearest to a point. (p, m, x, y, z, dx, dy, dz, end): where a ray that begins outside meets it, in units of |d|; inf
where it does not up to `end`. (p, m, x, y, z, direction, reach, skin): whether it stands between a point and a
light."""
meets, look, drift = map(of_class, ("meets", "look", "drift"))
"""(p, m, rays, found), (p, m, x, y, z, eye, width, before), (p, m, x, y, z): as `SolidShape` has them, the last two in
the world."""
bounds, deepest = of_class("bounds"), of_class("deepest")
"""(p, m): low and high corner, in the frame of solid m, of a box that no point is nearer to the solid than to.
(p, m, begin, edge): the share of a segment after which it is deepest, and the depth there."""
distances_in_own, slopes_in_own = of_class("distances_in_own", inline=True), of_class("slopes_in_own", inline=True)
"""(p, m, u, v, w): distances of vectors of points, in the frame of solid m; and these with their gradients."""


@device
def distance(p, m, x, y, z):
    """Distance of a point from the surface of solid m, metres; negative inside."""
    u, v, w = own(p, m, x, y, z)
    return distance_in_own(p, m, u, v, w)


@by_type
def number(p, m, column):
    """A number of solid m: that of a column of its row."""
    if isinstance(p.types[p.fields.index("rows")], types.Array):
        return lambda p, m, column: p.rows[m, column]
    return lambda p, m, column: p.rows[m + column]


@by_type
def rounded(p, value):
    """A number in single precision where rows are an array; kernels of rods, which may be in double, keep it."""
    if isinstance(p.types[p.fields.index("rows")], types.Array):
        return lambda p, value: np.float32(value)
    return lambda p, value: value


@device
def own(p, m, x, y, z):
    """A point in the frame of solid m."""
    return own_direction(p, m, x - number(p, m, X), y - number(p, m, Y), z - number(p, m, Z))


@device
def own_direction(p, m, x, y, z):
    """A direction in the frame of solid m."""
    return (
        number(p, m, ROW_X) * x + number(p, m, ROW_Y) * y + number(p, m, ROW_Z) * z,
        number(p, m, ROW_X + 1) * x + number(p, m, ROW_Y + 1) * y + number(p, m, ROW_Z + 1) * z,
        number(p, m, ROW_X + 2) * x + number(p, m, ROW_Y + 2) * y + number(p, m, ROW_Z + 2) * z,
    )


@device
def ray_in_own(p, m, x, y, z, dx, dy, dz):
    """Origin and direction of a ray in the frame of solid m, in double precision."""
    u, v, w = own(p, m, x, y, z)
    a, b, c = own_direction(p, m, dx, dy, dz)
    return np.float64(u), np.float64(v), np.float64(w), np.float64(a), np.float64(b), np.float64(c)


@device
def outward(p, m, n):
    """The unit direction in the world of a direction in the frame of solid m."""
    f = 1.0 / math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
    return in_world(p, m, (f * n[0], f * n[1], f * n[2]))


@device
def in_world(p, m, v):
    """A vector of the frame of solid m in the world."""
    a, b, c = v
    return (
        number(p, m, ROW_X) * a + number(p, m, ROW_X + 1) * b + number(p, m, ROW_X + 2) * c,
        number(p, m, ROW_Y) * a + number(p, m, ROW_Y + 1) * b + number(p, m, ROW_Y + 2) * c,
        number(p, m, ROW_Z) * a + number(p, m, ROW_Z + 1) * b + number(p, m, ROW_Z + 2) * c,
    )


@device
def look_in_world(p, m, look):
    """How solid m looks: its normal, place and colour from those of its own frame, in single precision; and a whole
    number."""
    n, place, colour, nearby = look
    x, y, z = outward(p, m, n)
    a, b, c = place
    u = number(p, m, X) + number(p, m, ROW_X) * a + number(p, m, ROW_X + 1) * b + number(p, m, ROW_X + 2) * c
    v = number(p, m, Y) + number(p, m, ROW_Y) * a + number(p, m, ROW_Y + 1) * b + number(p, m, ROW_Y + 2) * c
    w = number(p, m, Z) + number(p, m, ROW_Z) * a + number(p, m, ROW_Z + 1) * b + number(p, m, ROW_Z + 2) * c
    return (
        (np.float32(x), np.float32(y), np.float32(z)), (np.float32(u), np.float32(v), np.float32(w)),
        (np.float32(colour[0]), np.float32(colour[1]), np.float32(colour[2])), np.int64(nearby),
    )  # fmt: skip


@device
def gradient(p, m, h, x, y, z):
    """Unit direction in which the distance from solid m grows most, by differences over 2 h."""
    nx = distance(p, m, x + h, y, z) - distance(p, m, x - h, y, z)
    ny = distance(p, m, x, y + h, z) - distance(p, m, x, y - h, z)
    nz = distance(p, m, x, y, z + h) - distance(p, m, x, y, z - h)
    square = nx * nx + ny * ny + nz * nz
    if square < TINY * h * h:  # as far from all of the surface: up
        return 0.0 * x, 0.0 * x + 1.0, 0.0 * x
    f = 1.0 / math.sqrt(square)
    return f * nx, f * ny, f * nz


@device
def through(p, m, ox, oy, oz, dx, dy, dz):
    """Where a ray enters the ball about solid m and leaves it, in units of |d|; the second is negative for a miss."""
    dd = dx * dx + dy * dy + dz * dz
    cx = number(p, m, X) - ox
    cy = number(p, m, Y) - oy
    cz = number(p, m, Z) - oz
    t = (cx * dx + cy * dy + cz * dz) / dd
    cx -= t * dx
    cy -= t * dy
    cz -= t * dz
    left = number(p, m, REACH) * number(p, m, REACH) - (cx * cx + cy * cy + cz * cz)
    if left <= ZERO:
        return ZERO, -ONE
    half = np.float32(math.sqrt(left / dd))
    return max(t - half, ZERO), t + half


def march(p, m, x, y, z, dx, dy, dz, end):
    """Where a ray that begins outside of solid m meets it, in units of |d|; inf where it does not up to ``end`` (Hart
    1996, "Sphere Tracing")."""
    t = ZERO
    per = ONE / np.float32(math.sqrt(dx * dx + dy * dy + dz * dz))
    near = NEAR * number(p, m, REACH)
    for _ in range(STEPS):
        away = distance(p, m, x + t * dx, y + t * dy, z + t * dz)
        if t > end:
            return INF
        if away < near:
            return t
        t += away * per
    return INF


@device
def trace(p, m, ox, oy, oz, dx, dy, dz):
    """Where a ray meets solid m from outside, in units of |d|; inf where it does not. `meet` begins where the ray
    enters the solid's ball, so that it need not be accurate from far away."""
    t, end = through(p, m, ox, oy, oz, dx, dy, dz)
    if end < t:
        return INF
    x, y, z = ox + t * dx, oy + t * dy, oz + t * dz
    if t == ZERO and distance(p, m, x, y, z) < ZERO:
        return INF
    return t + meet(p, m, x, y, z, dx, dy, dz, end - t)


def hides_by_distance(p, m, x, y, z, direction, reach, skin):
    """Whether solid m stands between a point, already `skin` off its own place, and a light at ``reach`` along the unit
    vector ``direction``. A point on the surface, or within `skin` under it, has to come clear of that first."""
    lx, ly, lz = direction
    t, end = through(p, m, x, y, z, lx, ly, lz)
    end = min(end, reach)
    near = NEAR * number(p, m, REACH)
    before = -INF
    for _ in range(STEPS):
        if t > end:
            return False
        away = distance(p, m, x + t * lx, y + t * ly, z + t * lz)
        if away < -skin or (away < before and away < near):
            return True
        if away >= near:
            return meet(p, m, x + t * lx, y + t * ly, z + t * lz, lx, ly, lz, end - t) <= end - t
        before = away
        t += max(abs(away), near)
    return False


@device
def put_outside(p, m, x, y, z, clear):
    """A point, moved to `clear` metres off the surface of solid m where it is nearer or inside."""
    dx = x - number(p, m, X)
    dy = y - number(p, m, Y)
    dz = z - number(p, m, Z)
    reach = number(p, m, REACH) + clear
    if dx * dx + dy * dy + dz * dz < reach * reach:
        enough = OUT * number(p, m, REACH)
        for _ in range(ROUNDS):
            under = clear - distance(p, m, x, y, z)
            if under <= enough:
                break
            nx, ny, nz = normal(p, m, x, y, z)
            x = np.float32(x + under * nx)
            y = np.float32(y + under * ny)
            z = np.float32(z + under * nz)
    return x, y, z


@device
def put_outside_all(p, x, y, z, clear):
    """A point out of all of these solids, one after the other."""
    for m in range(p.rows.shape[0]):
        x, y, z = put_outside(p, m, x, y, z, clear)
    return x, y, z


@device
def visibility_past_all(p, x, y, z, lx, ly, lz, reach, skin):
    """Return 1 if `hides` is false for all of these solids, else 0."""
    for m in range(p.rows.shape[0]):
        if hides(p, m, x, y, z, (lx, ly, lz), reach, skin):
            return ZERO
    return ONE
