"""Compiled functions of spheres: intersection with rays, visibility, normals, depth, contact.

`p` holds packed spheres, one in each row; m is a row's number, or in functions of vectors of lanes the index where the
row begins.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...constants import W
from ...jit import device, inlined
from ...simd import any_lane, broadcast, load3, sqrt
from ..shapes.sphere import LEAST, RADIUS, X, Y, Z

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
INF = np.float32(np.inf)
TINY = np.float32(1e-20)
NONE = 1e-30
"""Least divisor: squared length of a segment, m²."""
BARELY_OUT = 1.000001
"""Squared distance, as a multiple of the squared radius, at which a point is not inside, whatever the rounding."""
MOST_NEARER = 0.25
"""Of the squared length of a segment, the most by which a point of it is nearer than both of its ends, squared."""
ROUNDING = 1e-6
"""Of squared distances, as a share: more than there is."""


@device
def meet(p, m, ox, oy, oz, dx, dy, dz):
    """Return the distance along a ray, in units of |d|, to sphere m; inf if it misses or begins inside."""
    # no view p[m]: it would be reference counted, by atomic instructions
    cx = ox - p[m, X]
    cy = oy - p[m, Y]
    cz = oz - p[m, Z]
    a = dx * dx + dy * dy + dz * dz
    b = cx * dx + cy * dy + cz * dz
    # from the distance between centre and ray; b² − a c cancels for a distant small sphere (Haines 2019)
    t = -b / a
    ex = cx + t * dx
    ey = cy + t * dy
    ez = cz + t * dz
    left = p[m, RADIUS] * p[m, RADIUS] - (ex * ex + ey * ey + ez * ez)
    hit = t - math.sqrt(max(left, ZERO) / a)
    return hit if (left >= ZERO) & (t >= ZERO) else INF


@device
def visibility(p, m, x, y, z, lx, ly, lz, reach, skin):
    """Return 0 if sphere m is between a point and a light at the distance `reach` along the unit direction l, else 1.
    Points up to `skin` below the surface count as on it. Without branches."""
    cx = p[m, X] - x - skin * lx
    cy = p[m, Y] - y - skin * ly
    cz = p[m, Z] - z - skin * lz
    t = cx * lx + cy * ly + cz * lz
    left = (p[m, RADIUS] - skin) * (p[m, RADIUS] - skin) - (cx * cx + cy * cy + cz * cz - t * t)
    near = t - math.sqrt(max(left, ZERO))
    return ZERO if (t > ZERO) & (p[m, RADIUS] > skin) & (left > ZERO) & (near < reach) else ONE


@device
def normal(p, m, x, y, z):
    """Return the outward normal at a point of the surface, not of unit length."""
    return x - p[m, X], y - p[m, Y], z - p[m, Z]


@device
def outside(p, m, x, y, z, clear):
    """Return a point, moved to `clear` metres from the surface if it is nearer or inside."""
    return push_out(x, y, z, p[m, X], p[m, Y], p[m, Z], p[m, RADIUS] + clear)


@device
def push_out(x, y, z, ox, oy, oz, r):
    """Return a point, moved to the distance r from (ox, oy, oz) if it is nearer; from the centre itself upward."""
    dx = x - ox
    dy = y - oy
    dz = z - oz
    square = dx * dx + dy * dy + dz * dz
    if square >= r * r:
        return x, y, z
    if square < TINY:
        return ox, oy + r, oz
    f = r / math.sqrt(square)
    return ox + dx * f, oy + dy * f, oz + dz * f


@inlined
def ball_depth(dx, dy, dz, r):
    """Return the depth in a ball of radius r of points at (dx, dy, dz) from its centre; vectors of lanes."""
    return r - sqrt(dx * dx + dy * dy + dz * dz)


@device
def depth(p, m, x, y, z):
    """Return the depth of points in sphere m, negative outside; vectors of lanes."""
    return ball_depth(x - p[m + X], y - p[m + Y], z - p[m + Z], p[m + RADIUS])


@device
def segment_depth(p, m, start, edge):
    """Return the greatest depth in sphere m of the points of a segment from ``start`` to ``start`` + ``edge``: that of
    the point nearest to the centre; negative outside. Vectors of lanes."""
    x, y, z = off_centre(p, m, start, edge)
    return ball_depth(x, y, z, p[m + RADIUS])


@inlined
def off_centre(p, m, start, edge):
    """Return the vector from the centre of sphere m to the nearest point of a segment; vectors of lanes."""
    x, y, z = start[0] - p[m + X], start[1] - p[m + Y], start[2] - p[m + Z]
    square = edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2]
    t = min(max(-(x * edge[0] + y * edge[1] + z * edge[2]) / max(square, NONE), 0.0), 1.0)
    return x + t * edge[0], y + t * edge[1], z + t * edge[2]


@device
def deepest(p, m, x, o, rows):
    """Return the greatest depths in sphere m of particles of strands, and of points of their segments; vectors of
    lanes, not negative.

    x: positions, of which ``o`` is the place of the roots and ``rows`` the number of particles. Roots are left out, and
    of the first segment only the depth in excess of its root's counts.
    """
    radius = p[m + RADIUS]
    a = load3(x, o, W)
    b = load3(x, o + 3 * W, W)
    e = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    under = max(0.0, depth(p, m, a[0], a[1], a[2]))
    along = broadcast(x, 0.0)
    if any_lane((a[0] - p[m + X]) * e[0] + (a[1] - p[m + Y]) * e[1] + (a[2] - p[m + Z]) * e[2] < 0.0):
        along = max(along, segment_depth(p, m, a, e) - under)
    # squares of distances from the centre: of the nearest end, and of the nearest point; their roots tell the depths
    s = b[0] - p[m + X], b[1] - p[m + Y], b[2] - p[m + Z]
    before = s[0] * s[0] + s[1] * s[1] + s[2] * s[2]
    ends = min(radius * radius * BARELY_OUT, before)
    inner = ends
    for i in range(2, rows):
        b = load3(x, o + i * 3 * W, W)
        q = s
        s = b[0] - p[m + X], b[1] - p[m + Y], b[2] - p[m + Z]
        after = s[0] * s[0] + s[1] * s[1] + s[2] * s[2]
        dot = q[0] * s[0] + q[1] * s[1] + q[2] * s[2]
        nearest = min(before, after)
        # a segment comes nearer than both ends if dot < nearest, by no more than a quarter of its squared length
        least = nearest - MOST_NEARER * (before + after - 2.0 * dot) - ROUNDING * (before + after)
        if any_lane(max(dot - nearest, least - inner) < 0.0):  # one comparison for two
            a = load3(x, o + (i - 1) * 3 * W, W)
            e = b[0] - a[0], b[1] - a[1], b[2] - a[2]
            c = off_centre(p, m, a, e)
            inner = min(inner, c[0] * c[0] + c[1] * c[1] + c[2] * c[2])
        before = after
        ends = min(ends, after)
        inner = min(inner, after)
    if rows > 2:
        along = max(along, radius - sqrt(inner))
    return max(0.0, radius - sqrt(ends)), along


def collide(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """Move particles inside of spheres to the surface.

    A pass of the stage "particle"; parameters as in `strandcli.simulate.rules.Pass`.
    """
    for s in range(p.shape[0]):
        ox = p[s, X]
        oy = p[s, Y]
        oz = p[s, Z]
        r = p[s, RADIUS]
        tiny = p[s, LEAST]
        reach = r * r
        inside = 0
        for k in range(W):
            dx = x[k] - ox
            dy = x[W + k] - oy
            dz = x[2 * W + k] - oz
            inside += 1 if dx * dx + dy * dy + dz * dz < reach else 0
        if inside == 0:
            continue
        for k in range(W):
            dx = x[k] - ox
            dy = x[W + k] - oy
            dz = x[2 * W + k] - oz
            square = dx * dx + dy * dy + dz * dz
            size = math.sqrt(max(square, tiny))
            # at the centre the normal is undefined; +y is used
            dy = dy if square > tiny else size
            f = max(r / size - ONE, ZERO)
            x[k] += dx * f
            x[W + k] += dy * f
            x[2 * W + k] += dz * f
