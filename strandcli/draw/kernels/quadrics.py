"""Rays against spheres and capsules, packed by `strandcli.solids.pack`."""

from __future__ import annotations

import math

import numpy as np

from ...jit import inner

ZERO = np.float32(0.0)
TINY = np.float32(1e-20)
INF = np.float32(np.inf)


@inner
def sphere(p, m, room, ox, oy, oz, dx, dy, dz):
    """Distance along the ray, in units of |d|, to the outside of sphere number m, ``room`` metres thicker; inf where it
    is missed or begins inside. (A row of p would be a view, and views are counted by an atomic instruction: an index
    is not.)"""
    cx = ox - p[m, 0]
    cy = oy - p[m, 1]
    cz = oz - p[m, 2]
    a = dx * dx + dy * dy + dz * dz
    b = cx * dx + cy * dy + cz * dz
    # the distance of the centre from the ray, not b² − a c: that cancels for a far and small sphere (Haines 2019)
    t = -b / a
    ex = cx + t * dx
    ey = cy + t * dy
    ez = cz + t * dz
    r = p[m, 3] + room
    left = r * r - (ex * ex + ey * ey + ez * ez)
    hit = t - math.sqrt(max(left, ZERO) / a)
    return hit if (left >= ZERO) & (t >= ZERO) else INF


@inner
def capsule(p, m, room, ox, oy, oz, dx, dy, dz):
    """As `sphere`, for a capsule: the open cylinder, then its two ends; without branches. Negative where it lies behind
    the ray's begin, or about it."""
    cx = ox - p[m, 0]
    cy = oy - p[m, 1]
    cz = oz - p[m, 2]
    bx = p[m, 3]
    by = p[m, 4]
    bz = p[m, 5]
    r = p[m, 6] + room
    bb = bx * bx + by * by + bz * bz
    dd = dx * dx + dy * dy + dz * dz
    bd = bx * dx + by * dy + bz * dz
    bo = bx * cx + by * cy + bz * cz
    a = bb * dd - bd * bd
    askew = max(a, TINY)
    # from the ray's nearest point to the axis, as for a sphere
    t = (bo * bd - bb * (cx * dx + cy * dy + cz * dz)) / askew
    y = (bo + t * bd) / max(bb, TINY)
    ex = cx + t * dx - y * bx
    ey = cy + t * dy - y * by
    ez = cz + t * dz - y * bz
    left = r * r - (ex * ex + ey * ey + ez * ez)
    t -= math.sqrt(max(left, ZERO) * bb / askew)
    along = bo + t * bd
    side = t if (left >= ZERO) & (bb > TINY) & (a > TINY) & (along > ZERO) & (along < bb) else INF
    begin = end_of(r, cx, cy, cz, dx, dy, dz, dd)
    return min(side, min(begin, end_of(r, cx - bx, cy - by, cz - bz, dx, dy, dz, dd)))


@inner
def end_of(r, cx, cy, cz, dx, dy, dz, dd):
    """Distance to a capsule's end, a ball from whose centre the ray begins at c."""
    t = -(cx * dx + cy * dy + cz * dz) / dd
    ex = cx + t * dx
    ey = cy + t * dy
    ez = cz + t * dz
    left = r * r - (ex * ex + ey * ey + ez * ez)
    return t - math.sqrt(max(left, ZERO) / dd) if left >= ZERO else INF
