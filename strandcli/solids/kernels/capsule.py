"""Compiled functions of capsules: as `sphere`; `p` holds packed capsules."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba.extending import register_jitable

from ...constants import W
from ...jit import device, inlined
from ...simd import where
from ..shapes.capsule import AXIS_X, AXIS_Y, AXIS_Z, LEAST, PER_SQUARE, RADIUS, X, Y, Z
from . import sphere
from .sphere import INF, ONE, TINY, ZERO

HALF = np.float32(0.5)
PARALLEL = 1e-12
"""Squared sine of the angle below which two segments count as parallel."""


@inlined
def meet(p, m, ox, oy, oz, dx, dy, dz):
    """Return the distance as `sphere.meet`, from the open cylinder and the two end balls; without branches."""
    cx = ox - p[m, X]
    cy = oy - p[m, Y]
    cz = oz - p[m, Z]
    bx = p[m, AXIS_X]
    by = p[m, AXIS_Y]
    bz = p[m, AXIS_Z]
    r = p[m, RADIUS]
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
    begin = meet_end(r, cx, cy, cz, dx, dy, dz, dd)
    return min(side, min(begin, meet_end(r, cx - bx, cy - by, cz - bz, dx, dy, dz, dd)))


@inlined
def meet_end(r, cx, cy, cz, dx, dy, dz, dd):
    """Return the distance to a capsule's end, a ball; c: start of the ray relative to the centre; dd: d · d."""
    t = -(cx * dx + cy * dy + cz * dz) / dd
    ex = cx + t * dx
    ey = cy + t * dy
    ez = cz + t * dz
    left = r * r - (ex * ex + ey * ey + ez * ez)
    return t - math.sqrt(max(left, ZERO) / dd) if left >= ZERO else INF


@inlined
def misses_ball(p, m, x, y, z, lx, ly, lz):
    """Return whether a ray certainly misses the bounding ball of capsule m; without a square root."""
    hx = HALF * p[m, AXIS_X]
    hy = HALF * p[m, AXIS_Y]
    hz = HALF * p[m, AXIS_Z]
    cx = p[m, X] + hx - x
    cy = p[m, Y] + hy - y
    cz = p[m, Z] + hz - z
    t = cx * lx + cy * ly + cz * lz
    # (a + b)² <= 2 (a² + b²)
    square = hx * hx + hy * hy + hz * hz + p[m, RADIUS] * p[m, RADIUS]
    return cx * cx + cy * cy + cz * cz - t * t > square + square


@device
def visibility(p, m, x, y, z, lx, ly, lz, reach, skin):
    """Return the visibility as `sphere.visibility`, from a point that is already moved by `skin` along l."""
    if misses_ball(p, m, x, y, z, lx, ly, lz):
        return ONE
    t = meet(p, m, x, y, z, lx, ly, lz)
    return ZERO if (skin < t) & (t < reach) else ONE


@device
def normal(p, m, x, y, z):
    """Return the outward normal at a point of the surface, from the nearest point of the axis; not of unit length."""
    nx = x - p[m, X]
    ny = y - p[m, Y]
    nz = z - p[m, Z]
    t = min(max((nx * p[m, AXIS_X] + ny * p[m, AXIS_Y] + nz * p[m, AXIS_Z]) * p[m, PER_SQUARE], ZERO), ONE)
    return nx - t * p[m, AXIS_X], ny - t * p[m, AXIS_Y], nz - t * p[m, AXIS_Z]


@device
def outside(p, m, x, y, z, clear):
    """Return a point, moved to `clear` metres from the surface if it is nearer or inside."""
    t = (x - p[m, X]) * p[m, AXIS_X] + (y - p[m, Y]) * p[m, AXIS_Y]
    t = min(max((t + (z - p[m, Z]) * p[m, AXIS_Z]) * p[m, PER_SQUARE], ZERO), ONE)
    return sphere.push_out(
        x, y, z, p[m, X] + t * p[m, AXIS_X], p[m, Y] + t * p[m, AXIS_Y], p[m, Z] + t * p[m, AXIS_Z],
        p[m, RADIUS] + clear,
    )  # fmt: skip


@inlined
def on_axis(p, m, x, y, z):
    """Return the point of a capsule's axis nearest to (x, y, z); vectors of lanes."""
    ax, ay, az = p[m + AXIS_X], p[m + AXIS_Y], p[m + AXIS_Z]
    t = (x - p[m + X]) * ax + (y - p[m + Y]) * ay + (z - p[m + Z]) * az
    t = min(max(t * p[m + PER_SQUARE], 0.0), 1.0)
    return p[m + X] + t * ax, p[m + Y] + t * ay, p[m + Z] + t * az


@device
def depth(p, m, x, y, z):
    """Return the depth of points in capsule m, negative outside; vectors of lanes."""
    ox, oy, oz = on_axis(p, m, x, y, z)
    return sphere.ball_depth(x - ox, y - oy, z - oz, p[m + RADIUS])


@device
def segment_depth(p, m, start, edge):
    """Return the depth as `sphere.segment_depth`."""
    (x, y, z), _ = off_axis(p, m, start, edge)
    return sphere.ball_depth(x, y, z, p[m + RADIUS])


@inlined
def off_axis(p, m, start, edge):
    """Return the shortest vector from capsule m's axis to a segment, and at which share of that it ends: the closest
    points of two segments (Ericson 2005, §5.1.9); vectors of lanes."""
    ax, ay, az = p[m + AXIS_X], p[m + AXIS_Y], p[m + AXIS_Z]
    x, y, z = start[0] - p[m + X], start[1] - p[m + Y], start[2] - p[m + Z]
    ee = max(edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2], sphere.NONE)
    aa = max(ax * ax + ay * ay + az * az, sphere.NONE)
    ea = edge[0] * ax + edge[1] * ay + edge[2] * az
    er = edge[0] * x + edge[1] * y + edge[2] * z
    ar = ax * x + ay * y + az * z
    area = ee * aa - ea * ea
    t = (ea * ar - er * aa) / max(area, sphere.NONE)
    t = where(area > PARALLEL * ee * aa, min(max(t, 0.0), 1.0), 0.0)
    u = min(max((ar + t * ea) / aa, 0.0), 1.0)
    t = min(max((u * ea - er) / ee, 0.0), 1.0)
    u = min(max((ar + t * ea) / aa, 0.0), 1.0)
    return (x + t * edge[0] - u * ax, y + t * edge[1] - u * ay, z + t * edge[2] - u * az), t


@register_jitable(error_model="numpy")  # for plain Python too, in which `strandcli.simulate.health` runs passes
def bounding_ball(p: Any, m: Any) -> Any:
    """Return the centre and the squared radius of the bounding ball of row m of packed capsules, metres."""
    ax, ay, az = p[m, AXIS_X], p[m, AXIS_Y], p[m, AXIS_Z]
    reach = HALF * math.sqrt(ax * ax + ay * ay + az * az) + p[m, RADIUS]
    return p[m, X] + HALF * ax, p[m, Y] + HALF * ay, p[m, Z] + HALF * az, reach * reach


def collide(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """Move particles inside of capsules to the surface, as `sphere.collide`; from the axis itself at right angles."""
    for s in range(p.shape[0]):
        ax = p[s, X]
        ay = p[s, Y]
        az = p[s, Z]
        bx = p[s, AXIS_X]
        by = p[s, AXIS_Y]
        bz = p[s, AXIS_Z]
        r = p[s, RADIUS]
        per = p[s, PER_SQUARE]
        tiny = p[s, LEAST]
        mx, my, mz, reach = bounding_ball(p, s)
        near = 0
        for k in range(W):
            dx = x[k] - mx
            dy = x[W + k] - my
            dz = x[2 * W + k] - mz
            near += 1 if dx * dx + dy * dy + dz * dz <= reach else 0
        if near == 0:  # all lanes are outside of the bounding ball
            continue
        # perpendicular to the axis, for particles on it
        flat = bx * bx + bz * bz
        size = math.sqrt(max(flat, tiny))
        ux = r * bz / size if flat > tiny else r
        uz = -r * bx / size if flat > tiny else ZERO
        for k in range(W):
            dx = x[k] - ax
            dy = x[W + k] - ay
            dz = x[2 * W + k] - az
            t = min(max((dx * bx + dy * by + dz * bz) * per, ZERO), ONE)
            dx -= t * bx
            dy -= t * by
            dz -= t * bz
            square = dx * dx + dy * dy + dz * dz
            f = max(r / math.sqrt(max(square, tiny)) - ONE, ZERO) if square > tiny else ZERO
            x[k] += dx * f if square > tiny else ux
            x[W + k] += dy * f
            x[2 * W + k] += dz * f if square > tiny else uz
