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
from ...simd import sqrt
from ..shapes.sphere import LEAST, RADIUS, X, Y, Z

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
INF = np.float32(np.inf)
TINY = np.float32(1e-20)
NONE = 1e-30
"""Least divisor: squared length of a segment, m²."""


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
