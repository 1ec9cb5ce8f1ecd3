"""Solids by their signed distance alone, in kernels: rays, normals, shadows and contact.

`distance(p, m, x, y, z)` is that of a written module (`strandcli.solids.shapes.other`), p an array of packed solids and
m the number of one of them.
"""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import device
from ..shapes.other import REACH, ROW_X, ROW_Y, ROW_Z, X, Y, Z

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
"""Half the way over which a gradient is measured, as a share of the reach."""
ROUNDS = 4
"""Steps of a point on its way out, at the most: one is enough for an exact distance."""
ACROSS = 64
"""Parts of the way through a solid's ball that a search for its edge looks at, at the least."""
PARTS = 4
"""Of a segment that is looked at between its ends."""
CLEAR = np.float32(2.0)
"""More than any sine."""


@device
def own(p, m, x, y, z):
    """A point in the frame of solid m."""
    x -= p[m, X]
    y -= p[m, Y]
    z -= p[m, Z]
    return (
        p[m, ROW_X] * x + p[m, ROW_Y] * y + p[m, ROW_Z] * z,
        p[m, ROW_X + 1] * x + p[m, ROW_Y + 1] * y + p[m, ROW_Z + 1] * z,
        p[m, ROW_X + 2] * x + p[m, ROW_Y + 2] * y + p[m, ROW_Z + 2] * z,
    )


@device
def own_at(p, m, x, y, z):
    """The same of the solid whose row begins at place m."""
    x -= p[m + X]
    y -= p[m + Y]
    z -= p[m + Z]
    return (
        p[m + ROW_X] * x + p[m + ROW_Y] * y + p[m + ROW_Z] * z,
        p[m + ROW_X + 1] * x + p[m + ROW_Y + 1] * y + p[m + ROW_Z + 1] * z,
        p[m + ROW_X + 2] * x + p[m + ROW_Y + 2] * y + p[m + ROW_Z + 2] * z,
    )


@device
def gradient(distance, p, m, h, x, y, z):
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
    cx = p[m, X] - ox
    cy = p[m, Y] - oy
    cz = p[m, Z] - oz
    t = (cx * dx + cy * dy + cz * dz) / dd
    cx -= t * dx
    cy -= t * dy
    cz -= t * dz
    left = p[m, REACH] * p[m, REACH] - (cx * cx + cy * cy + cz * cz)
    if left <= ZERO:
        return ZERO, -ONE
    half = np.float32(math.sqrt(left / dd))
    return max(t - half, ZERO), t + half


@device
def trace(distance, p, m, ox, oy, oz, dx, dy, dz):
    """Where a ray meets solid m from outside, in units of |d|; inf where it does not (Hart 1996, "Sphere Tracing")."""
    t, end = through(p, m, ox, oy, oz, dx, dy, dz)
    per = ONE / np.float32(math.sqrt(dx * dx + dy * dy + dz * dz))
    near = NEAR * p[m, REACH]
    for step in range(STEPS):
        away = distance(p, m, ox + t * dx, oy + t * dy, oz + t * dz)
        if step == 0 and away < ZERO:
            return INF
        if t > end:
            return INF
        if away < near:
            return t
        t += away * per
    return INF


@device
def hides(distance, p, m, x, y, z, way, reach, skin):
    """Whether solid m stands between a point, already `skin` off its own place, and a light at ``reach`` along the unit
    vector ``way``. A point on the surface, or within `skin` under it, has to come clear of that first."""
    lx, ly, lz = way
    t, end = through(p, m, x, y, z, lx, ly, lz)
    end = min(end, reach)
    near = NEAR * p[m, REACH]
    leaving = True
    before = -INF
    for _ in range(STEPS):
        if t > end:
            return False
        away = distance(p, m, x + t * lx, y + t * ly, z + t * lz)
        if leaving:
            if away < -skin or (away < before and away < near):
                return True
            leaving = away < near
            before = away
            t += max(abs(away), near)
        else:
            if away < near:
                return True
            t += away
    return False


@device
def least_sine(distance, p, m, x, y, z, way, reach, skin):
    """Sine of the least angle between a unit vector and the edge of solid m, less `skin`, as seen from a point: the
    least of its distance over the distance travelled, in steps of that distance."""
    lx, ly, lz = way
    cx = p[m, X] - x
    cy = p[m, Y] - y
    cz = p[m, Z] - z
    middle = cx * lx + cy * ly + cz * lz
    end = min(middle + p[m, REACH], reach)
    step = (p[m, REACH] + p[m, REACH]) / np.float32(ACROSS)
    t = max(middle - p[m, REACH], HALF * step)
    least = CLEAR
    while t < end:
        away = distance(p, m, x + t * lx, y + t * ly, z + t * lz) + skin
        least = min(least, away / t)
        t += max(abs(away) * HALF, step)
    return least


@device
def put_outside(distance, p, m, x, y, z, clear):
    """A point, moved to `clear` metres off the surface of solid m where it is nearer or inside."""
    dx = x - p[m, X]
    dy = y - p[m, Y]
    dz = z - p[m, Z]
    reach = p[m, REACH] + clear
    if dx * dx + dy * dy + dz * dz < reach * reach:
        for _ in range(ROUNDS):
            under = clear - distance(p, m, x, y, z)
            if under <= ZERO:
                break
            nx, ny, nz = gradient(distance, p, m, FINE * p[m, REACH], x, y, z)
            x = np.float32(x + under * nx)
            y = np.float32(y + under * ny)
            z = np.float32(z + under * nz)
    return x, y, z


@device
def put_segment_outside(distance, p, m, begin, x, y, z):
    """The far end of a segment, moved until the deepest of some points between is out of solid m."""
    for j in range(1, PARTS):
        t = np.float32(j) / np.float32(PARTS)
        qx = begin[0] + t * (x - begin[0])
        qy = begin[1] + t * (y - begin[1])
        qz = begin[2] + t * (z - begin[2])
        under = -distance(p, m, qx, qy, qz)
        if under > ZERO:
            nx, ny, nz = gradient(distance, p, m, FINE * p[m, REACH], qx, qy, qz)
            x = np.float32(x + under / t * nx)
            y = np.float32(y + under / t * ny)
            z = np.float32(z + under / t * nz)
    return x, y, z


@device
def put_outside_all(distance, p, x, y, z, clear):
    """A point out of all of these solids, one after the other."""
    for m in range(p.shape[0]):
        x, y, z = put_outside(distance, p, m, x, y, z, clear)
    return x, y, z


@device
def lit_past_all(distance, p, x, y, z, way, reach, skin):
    """`lit` of all of these solids."""
    for m in range(p.shape[0]):
        if hides(distance, p, m, x, y, z, way, reach, skin):
            return ZERO
    return ONE


@device
def least_sine_of_all(distance, p, x, y, z, way, reach, skin):
    """`least_sine` of all of these solids."""
    least = CLEAR
    for m in range(p.shape[0]):
        least = min(least, least_sine(distance, p, m, x, y, z, way, reach, skin))
    return least


@device
def deepest_of_all(distance, p, positions, b):
    """Greatest depth of a particle of block b of positions (blocks, n + 1, 3 W) in these solids, roots left out, and of
    some places of its segments; of the first segment what is deeper than its root. Metres."""
    most = ZERO
    along = ZERO
    for i in range(2, positions.shape[1]):
        for k in range(W):
            x, y, z = positions[b, i - 1, k], positions[b, i - 1, W + k], positions[b, i - 1, 2 * W + k]
            ex, ey, ez = positions[b, i, k] - x, positions[b, i, W + k] - y, positions[b, i, 2 * W + k] - z
            for m in range(p.shape[0]):
                root = max(-distance(p, m, x, y, z), ZERO) if i == 2 else ZERO
                for j in range(1, PARTS + 1):
                    t = np.float32(j) / np.float32(PARTS)
                    under = -distance(p, m, x + t * ex, y + t * ey, z + t * ez)
                    along = max(along, under - root)
                most = max(most, under)
    return most, along
