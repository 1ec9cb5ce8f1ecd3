"""Rays against solids: for drawing them, and for the shadows that they cast.

Solids come packed by `strandcli.solids.pack`, an array for each kind, (m, columns), of which any may be empty. They are
numbered through: spheres first, then capsules, planes and boxes.
"""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, function, inlined, parallel, prange
from ...common.kernels.keys import EMPTY, FIRST, LOW, SHIFT
from ...common.kernels.view_columns import (
    AXIS_X,
    AXIS_Y,
    DEPTH_RANGE,
    EYE_X,
    EYE_Y,
    EYE_Z,
    FOCAL,
    FORWARD_X,
    FORWARD_Y,
    FORWARD_Z,
    NEAR_PLANE,
    PERSPECTIVE,
    RIGHT_X,
    RIGHT_Y,
    RIGHT_Z,
    UP_X,
    UP_Y,
    UP_Z,
)
from . import smooth_union, sphere_tracing

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-20)
INF = np.float32(np.inf)


@device
def sphere(p, m, ox, oy, oz, dx, dy, dz):
    """Distance along the ray, in units of |d|, to the outside of sphere number m; inf where it is missed or begins
    inside. (A row of p would be a view, and views are counted by an atomic instruction: an index is not.)"""
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
    left = p[m, 3] * p[m, 3] - (ex * ex + ey * ey + ez * ez)
    hit = t - math.sqrt(max(left, ZERO) / a)
    return hit if (left >= ZERO) & (t >= ZERO) else INF


@inlined
def capsule(p, m, ox, oy, oz, dx, dy, dz):
    """As `sphere`, for a capsule: the open cylinder, then its two ends; without branches."""
    cx = ox - p[m, 0]
    cy = oy - p[m, 1]
    cz = oz - p[m, 2]
    bx = p[m, 3]
    by = p[m, 4]
    bz = p[m, 5]
    r = p[m, 6]
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


@inlined
def end_of(r, cx, cy, cz, dx, dy, dz, dd):
    """Distance to a capsule's end, a ball from whose centre the ray begins at c."""
    t = -(cx * dx + cy * dy + cz * dz) / dd
    ex = cx + t * dx
    ey = cy + t * dy
    ez = cz + t * dz
    left = r * r - (ex * ex + ey * ey + ez * ez)
    return t - math.sqrt(max(left, ZERO) / dd) if left >= ZERO else INF


@device
def plane(p, m, ox, oy, oz, dx, dy, dz):
    """As `sphere`, for the upper side of a plane."""
    down = p[m, 0] * dx + p[m, 1] * dy + p[m, 2] * dz
    over = p[m, 0] * ox + p[m, 1] * oy + p[m, 2] * oz - p[m, 3]
    if down >= ZERO or over < ZERO:
        return INF
    return -over / down


@device
def box(p, m, ox, oy, oz, dx, dy, dz):
    """As `sphere`, for a box, by slabs (Kay & Kajiya 1986)."""
    cx = ox - p[m, 0]
    cy = oy - p[m, 1]
    cz = oz - p[m, 2]
    enter = -INF
    leave = INF
    for k in range(3):
        o = p[m, 3 + k] * cx + p[m, 6 + k] * cy + p[m, 9 + k] * cz
        d = p[m, 3 + k] * dx + p[m, 6 + k] * dy + p[m, 9 + k] * dz
        if abs(d) < TINY:
            if abs(o) > p[m, 12 + k]:
                return INF
            continue
        near = (-p[m, 12 + k] - o) / d
        far = (p[m, 12 + k] - o) / d
        enter = max(enter, min(near, far))
        leave = min(leave, max(near, far))
    if enter > leave:
        return INF
    return enter


@function
def normal(spheres, capsules, planes, boxes, which, x, y, z):
    """Unit outward normal of solid number `which` at a point of its surface."""
    m = which
    if smooth_union.blends(spheres, capsules, m):
        return smooth_union.normal(spheres, capsules, x, y, z)
    if m < spheres.shape[0]:
        nx = x - spheres[m, 0]
        ny = y - spheres[m, 1]
        nz = z - spheres[m, 2]
    elif m < spheres.shape[0] + capsules.shape[0]:
        m -= spheres.shape[0]
        nx = x - capsules[m, 0]
        ny = y - capsules[m, 1]
        nz = z - capsules[m, 2]
        t = min(max((nx * capsules[m, 3] + ny * capsules[m, 4] + nz * capsules[m, 5]) * capsules[m, 7], ZERO), ONE)
        nx -= t * capsules[m, 3]
        ny -= t * capsules[m, 4]
        nz -= t * capsules[m, 5]
    elif m < spheres.shape[0] + capsules.shape[0] + planes.shape[0]:
        m -= spheres.shape[0] + capsules.shape[0]
        nx = planes[m, 0]
        ny = planes[m, 1]
        nz = planes[m, 2]
    else:
        m -= spheres.shape[0] + capsules.shape[0] + planes.shape[0]
        cx = x - boxes[m, 0]
        cy = y - boxes[m, 1]
        cz = z - boxes[m, 2]
        face = 0
        most = -INF
        side = ONE
        for k in range(3):
            u = boxes[m, 3 + k] * cx + boxes[m, 6 + k] * cy + boxes[m, 9 + k] * cz
            over = abs(u) - boxes[m, 12 + k]
            if over > most:
                most = over
                face = k
                side = ONE if u > ZERO else -ONE
        nx = side * boxes[m, 3 + face]
        ny = side * boxes[m, 6 + face]
        nz = side * boxes[m, 9 + face]
    size = ONE / math.sqrt(max(nx * nx + ny * ny + nz * nz, TINY))
    return nx * size, ny * size, nz * size


@function
def lit(spheres, capsules, planes, boxes, x, y, z, lx, ly, lz, reach, skin):
    """1 where nothing solid stands between a point and a light at `reach` along the unit direction l, else 0.

    Points within `skin` under a surface count as on it, so that a root is not shaded by the solid that it grows from:
    only what a ray meets or is inside of after `skin` hides the light.
    """
    for s in range(spheres.shape[0]):
        if past_sphere(spheres, s, x, y, z, lx, ly, lz, reach, skin) == ZERO:
            return ZERO
    return past_others(capsules, planes, boxes, x, y, z, lx, ly, lz, reach, skin)


@device
def past_sphere(p, m, x, y, z, lx, ly, lz, reach, skin):
    """`lit` for one sphere, without branches."""
    cx = p[m, 0] - x - skin * lx
    cy = p[m, 1] - y - skin * ly
    cz = p[m, 2] - z - skin * lz
    t = cx * lx + cy * ly + cz * lz
    left = (p[m, 3] - skin) * (p[m, 3] - skin) - (cx * cx + cy * cy + cz * cz - t * t)
    near = t - math.sqrt(max(left, ZERO))
    return ZERO if (t > ZERO) & (p[m, 3] > skin) & (left > ZERO) & (near < reach) else ONE


@inlined
def passes(p, m, x, y, z, lx, ly, lz):
    """Whether a ray passes the ball about a capsule for sure; without a root."""
    hx = HALF * p[m, 3]
    hy = HALF * p[m, 4]
    hz = HALF * p[m, 5]
    cx = p[m, 0] + hx - x
    cy = p[m, 1] + hy - y
    cz = p[m, 2] + hz - z
    t = cx * lx + cy * ly + cz * lz
    # (a + b)² <= 2 (a² + b²)
    square = hx * hx + hy * hy + hz * hz + p[m, 6] * p[m, 6]
    return cx * cx + cy * cy + cz * cz - t * t > square + square


@device
def past_capsule(p, m, x, y, z, lx, ly, lz, reach, skin):
    """`lit` for one capsule, from a point that has been moved by `skin`; without branches but where all is far."""
    if passes(p, m, x, y, z, lx, ly, lz):
        return ONE
    t = capsule(p, m, x, y, z, lx, ly, lz)
    return ZERO if (skin < t) & (t < reach) else ONE


@device
def past_others(capsules, planes, boxes, x, y, z, lx, ly, lz, reach, skin):
    """`lit` for all that are not spheres."""
    x += skin * lx
    y += skin * ly
    z += skin * lz
    for s in range(capsules.shape[0]):
        if past_capsule(capsules, s, x, y, z, lx, ly, lz, reach, skin) == ZERO:
            return ZERO
    for s in range(planes.shape[0]):
        t = plane(planes, s, x, y, z, lx, ly, lz)
        if skin < t < reach:
            return ZERO
    for s in range(boxes.shape[0]):
        t = box(boxes, s, x, y, z, lx, ly, lz)
        if skin < t < reach:
            return ZERO
    return ONE


@parallel
def draw(spheres, capsules, planes, boxes, frames, view, width, height, keys):
    """Fill the z-buffer with solids, and with `keys.EMPTY` where there are none.

    frames (m, 4) int64: for each solid the pixels it can touch, left, right, top, bottom (right and bottom not
    included); keys (height * width,) uint64. A row of a sphere or
    a capsule is one loop without branches, which becomes vector code.
    """
    flat = ONE - view[PERSPECTIVE]
    far = ONE / view[DEPTH_RANGE]
    for y in prange(height):
        row = keys[y * width : (y + 1) * width]
        row[:] = EMPTY
        up = (view[AXIS_Y] - np.float32(y) - HALF) / view[FOCAL]
        for m in range(frames.shape[0]):
            if y < frames[m, 2] or y >= frames[m, 3]:
                continue
            identity = FIRST + np.uint64(m)
            part = row[frames[m, 0] : frames[m, 1]]
            begin = np.float32(frames[m, 0]) + HALF - view[AXIS_X]
            if smooth_union.blends(spheres, capsules, m):
                work = np.zeros(sphere_tracing.ROWS * W, np.float32)
                for low in range(0, part.shape[0], W):
                    count = min(part.shape[0] - low, W)
                    for x in range(count):
                        aim(work, x, view, (begin + np.float32(low + x)) / view[FOCAL], up)
                    sphere_tracing.meet(work, count, spheres, capsules)
                    for x in range(count):
                        key = key_at(work[sphere_tracing.MET + x], view, flat, far, identity)
                        part[low + x] = min(part[low + x], key)
            elif m < spheres.shape[0]:
                for x in range(part.shape[0]):
                    ox, oy, oz, dx, dy, dz = ray(view, (begin + np.float32(x)) / view[FOCAL], up)
                    key = key_at(sphere(spheres, m, ox, oy, oz, dx, dy, dz), view, flat, far, identity)
                    part[x] = min(part[x], key)
            elif m < spheres.shape[0] + capsules.shape[0]:
                own = m - spheres.shape[0]
                for x in range(part.shape[0]):
                    ox, oy, oz, dx, dy, dz = ray(view, (begin + np.float32(x)) / view[FOCAL], up)
                    key = key_at(capsule(capsules, own, ox, oy, oz, dx, dy, dz), view, flat, far, identity)
                    part[x] = min(part[x], key)
            else:
                for x in range(part.shape[0]):
                    ox, oy, oz, dx, dy, dz = ray(view, (begin + np.float32(x)) / view[FOCAL], up)
                    t = meet(spheres, capsules, planes, boxes, m, ox, oy, oz, dx, dy, dz)
                    part[x] = min(part[x], key_at(t, view, flat, far, identity))


@device
def key_at(t, view, flat, far, identity):
    """The z-buffer's key of a solid at depth t, `keys.EMPTY` where t is not in front of the eye; flat: 1 for an
    orthographic view, far: one over its depth range."""
    # what lies behind an orthographic view's range is as far as its end
    q = (ONE - flat) / t + flat * max(ONE - (t - view[NEAR_PLANE]) * far, ZERO)
    key = ((LOW - np.uint64(np.float32(q).view(np.uint32))) << SHIFT) | identity
    return key if view[NEAR_PLANE] < t < INF else EMPTY


@function
def meet(spheres, capsules, planes, boxes, which, ox, oy, oz, dx, dy, dz):
    """Where a ray meets solid number `which`: its parameter, inf where it does not. What blends is met as one."""
    m = which
    if smooth_union.blends(spheres, capsules, m):
        return smooth_union.meet(spheres, capsules, ox, oy, oz, dx, dy, dz)
    if m < spheres.shape[0]:
        return sphere(spheres, m, ox, oy, oz, dx, dy, dz)
    m -= spheres.shape[0]
    if m < capsules.shape[0]:
        return capsule(capsules, m, ox, oy, oz, dx, dy, dz)
    m -= capsules.shape[0]
    if m < planes.shape[0]:
        return plane(planes, m, ox, oy, oz, dx, dy, dz)
    return box(boxes, m - planes.shape[0], ox, oy, oz, dx, dy, dz)


@device
def aim(work, j, view, right, up):
    """`ray`, as number j of a batch of `marching`."""
    ox, oy, oz, dx, dy, dz = ray(view, right, up)
    work[sphere_tracing.OX + j] = ox
    work[sphere_tracing.OY + j] = oy
    work[sphere_tracing.OZ + j] = oz
    work[sphere_tracing.DX + j] = dx
    work[sphere_tracing.DY + j] = dy
    work[sphere_tracing.DZ + j] = dz


@device
def ray(view, right, up):
    """Origin and direction of the ray through a point of the screen, (right, up) in metres at a depth of one metre; the
    direction's length is such that its parameter is the depth. No branch: view[PERSPECTIVE] is 1 for perspective,
    else 0."""
    ax = view[RIGHT_X] * right + view[UP_X] * up
    ay = view[RIGHT_Y] * right + view[UP_Y] * up
    az = view[RIGHT_Z] * right + view[UP_Z] * up
    spread = view[PERSPECTIVE]
    shift = ONE - spread
    return (
        view[EYE_X] + shift * ax,
        view[EYE_Y] + shift * ay,
        view[EYE_Z] + shift * az,
        view[FORWARD_X] + spread * ax,
        view[FORWARD_Y] + spread * ay,
        view[FORWARD_Z] + spread * az,
    )
