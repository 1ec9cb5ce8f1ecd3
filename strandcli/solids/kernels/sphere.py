"""A ball in kernels: rays, normals, depth and contact. `p` holds packed spheres, a row each; m is the number of one."""

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
"""Least square of a segment's length, in m², by which anything is divided."""


@device
def meet(p, m, ox, oy, oz, dx, dy, dz):
    """Distance along a ray, in units of |d|, to the outside of sphere m; inf where it misses or begins inside."""
    # p[m] would be a view, and views are counted by an atomic instruction: an index is not
    cx = ox - p[m, X]
    cy = oy - p[m, Y]
    cz = oz - p[m, Z]
    a = dx * dx + dy * dy + dz * dz
    b = cx * dx + cy * dy + cz * dz
    # the distance of the centre from the ray, not b² − a c: that cancels for a far and small sphere (Haines 2019)
    t = -b / a
    ex = cx + t * dx
    ey = cy + t * dy
    ez = cz + t * dz
    left = p[m, RADIUS] * p[m, RADIUS] - (ex * ex + ey * ey + ez * ez)
    hit = t - math.sqrt(max(left, ZERO) / a)
    return hit if (left >= ZERO) & (t >= ZERO) else INF


@device
def past(p, m, x, y, z, lx, ly, lz, reach, skin):
    """0 where sphere m stands between a point and a light at `reach` along the unit direction l, else 1; points within
    `skin` under the surface count as on it. Without branches."""
    cx = p[m, X] - x - skin * lx
    cy = p[m, Y] - y - skin * ly
    cz = p[m, Z] - z - skin * lz
    t = cx * lx + cy * ly + cz * lz
    left = (p[m, RADIUS] - skin) * (p[m, RADIUS] - skin) - (cx * cx + cy * cy + cz * cz - t * t)
    near = t - math.sqrt(max(left, ZERO))
    return ZERO if (t > ZERO) & (p[m, RADIUS] > skin) & (left > ZERO) & (near < reach) else ONE


@device
def normal(p, m, x, y, z):
    """Outward normal at a point of the surface, not of unit length."""
    return x - p[m, X], y - p[m, Y], z - p[m, Z]


@device
def outside(p, m, x, y, z, clear):
    """A point, moved to `clear` metres off the surface where it is nearer or inside."""
    return off(x, y, z, p[m, X], p[m, Y], p[m, Z], p[m, RADIUS] + clear)


@device
def off(x, y, z, ox, oy, oz, r):
    """A point, moved to the distance r from (ox, oy, oz) where it is nearer; one at the very centre leaves upward."""
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
def under(dx, dy, dz, r):
    """Depth, in a ball of radius r, of points (dx, dy, dz) away from its centre; vectors of lanes."""
    return r - sqrt(dx * dx + dy * dy + dz * dz)


@device
def depth(p, m, x, y, z):
    """Depth of points in the ball whose row begins at m; vectors of lanes."""
    return under(x - p[m + X], y - p[m + Y], z - p[m + Z], p[m + RADIUS])


@device
def segment_depth(p, m, start, edge):
    """Greatest depth in a ball of the places of a segment from ``start`` along ``edge``: that of the nearest to the
    centre; vectors of lanes. Not positive outside."""
    x, y, z = start[0] - p[m + X], start[1] - p[m + Y], start[2] - p[m + Z]
    square = edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2]
    t = min(max(-(x * edge[0] + y * edge[1] + z * edge[2]) / max(square, NONE), 0.0), 1.0)
    return under(x + t * edge[0], y + t * edge[1], z + t * edge[2], p[m + RADIUS])


def collide(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """Put particles inside of a ball onto its surface.

    A pass of the stage "particle", whose parameters `strandcli.simulate.rules.Pass` describes.
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
        if inside == 0:  # no lane needs the roots and divisions below
            continue
        for k in range(W):
            dx = x[k] - ox
            dy = x[W + k] - oy
            dz = x[2 * W + k] - oz
            square = dx * dx + dy * dy + dz * dz
            size = math.sqrt(max(square, tiny))
            # at the centre, where nothing points outward, up does
            dy = dy if square > tiny else size
            f = max(r / size - ONE, ZERO)
            x[k] += dx * f
            x[W + k] += dy * f
            x[2 * W + k] += dz * f
