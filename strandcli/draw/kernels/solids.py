"""Rays against solids: for drawing them, and for the shadows that they cast.

Solids come packed by `strandcli.solids.pack`, an array for each kind, (m, columns), of which any may be empty. They are
numbered through: spheres first, then capsules, planes and boxes.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import function, parallel, prange
from .raster import EMPTY, LOW, SHIFT

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-20)
INF = np.float32(np.inf)
FIRST = np.uint64(0xFFF00000)
"""Identities from here on are solids', a million of them, the others segments'."""


@function
def sphere(p, ox, oy, oz, dx, dy, dz):
    """Distance along the ray, in units of |d|, to a sphere's outside; inf where it is missed or begins inside."""
    cx = ox - p[0]
    cy = oy - p[1]
    cz = oz - p[2]
    a = dx * dx + dy * dy + dz * dz
    b = cx * dx + cy * dy + cz * dz
    # the distance of the centre from the ray, not b² − a c: that cancels for a far and small sphere (Haines 2019)
    t = -b / a
    ex = cx + t * dx
    ey = cy + t * dy
    ez = cz + t * dz
    left = p[3] * p[3] - (ex * ex + ey * ey + ez * ez)
    hit = t - math.sqrt(max(left, ZERO) / a)
    return hit if (left >= ZERO) & (t >= ZERO) else INF


@function
def capsule(p, ox, oy, oz, dx, dy, dz):
    """As `sphere`, for a capsule: the open cylinder, then its two ends."""
    cx = ox - p[0]
    cy = oy - p[1]
    cz = oz - p[2]
    bx = p[3]
    by = p[4]
    bz = p[5]
    r = p[6]
    bb = bx * bx + by * by + bz * bz
    dd = dx * dx + dy * dy + dz * dz
    best = INF
    if bb > TINY:
        bd = bx * dx + by * dy + bz * dz
        bo = bx * cx + by * cy + bz * cz
        a = bb * dd - bd * bd
        if a > TINY:
            # from the ray's nearest point to the axis, as for a sphere
            t = (bo * bd - bb * (cx * dx + cy * dy + cz * dz)) / a
            y = (bo + t * bd) / bb
            ex = cx + t * dx - y * bx
            ey = cy + t * dy - y * by
            ez = cz + t * dz - y * bz
            left = r * r - (ex * ex + ey * ey + ez * ez)
            if left >= ZERO:
                t -= math.sqrt(left * bb / a)
                if ZERO < bo + t * bd < bb:
                    best = t
    for _ in range(2):
        t = -(cx * dx + cy * dy + cz * dz) / dd
        ex = cx + t * dx
        ey = cy + t * dy
        ez = cz + t * dz
        left = r * r - (ex * ex + ey * ey + ez * ez)
        if left >= ZERO:
            best = min(best, t - math.sqrt(left / dd))
        cx -= bx
        cy -= by
        cz -= bz
    return best


@function
def plane(p, ox, oy, oz, dx, dy, dz):
    """As `sphere`, for the upper side of a plane."""
    down = p[0] * dx + p[1] * dy + p[2] * dz
    over = p[0] * ox + p[1] * oy + p[2] * oz - p[3]
    if down >= ZERO or over < ZERO:
        return INF
    return -over / down


@function
def box(p, ox, oy, oz, dx, dy, dz):
    """As `sphere`, for a box, by slabs (Kay & Kajiya 1986)."""
    cx = ox - p[0]
    cy = oy - p[1]
    cz = oz - p[2]
    enter = -INF
    leave = INF
    for k in range(3):
        o = p[3 + k] * cx + p[6 + k] * cy + p[9 + k] * cz
        d = p[3 + k] * dx + p[6 + k] * dy + p[9 + k] * dz
        if abs(d) < TINY:
            if abs(o) > p[12 + k]:
                return INF
            continue
        near = (-p[12 + k] - o) / d
        far = (p[12 + k] - o) / d
        enter = max(enter, min(near, far))
        leave = min(leave, max(near, far))
    if enter > leave:
        return INF
    return enter


@function
def normal(spheres, capsules, planes, boxes, which, x, y, z):
    """Unit outward normal of solid number `which` at a point of its surface."""
    m = which
    if m < spheres.shape[0]:
        p = spheres[m]
        nx = x - p[0]
        ny = y - p[1]
        nz = z - p[2]
    elif m < spheres.shape[0] + capsules.shape[0]:
        p = capsules[m - spheres.shape[0]]
        nx = x - p[0]
        ny = y - p[1]
        nz = z - p[2]
        t = min(max((nx * p[3] + ny * p[4] + nz * p[5]) * p[7], ZERO), ONE)
        nx -= t * p[3]
        ny -= t * p[4]
        nz -= t * p[5]
    elif m < spheres.shape[0] + capsules.shape[0] + planes.shape[0]:
        p = planes[m - spheres.shape[0] - capsules.shape[0]]
        nx = p[0]
        ny = p[1]
        nz = p[2]
    else:
        p = boxes[m - spheres.shape[0] - capsules.shape[0] - planes.shape[0]]
        cx = x - p[0]
        cy = y - p[1]
        cz = z - p[2]
        face = 0
        most = -INF
        side = ONE
        for k in range(3):
            u = p[3 + k] * cx + p[6 + k] * cy + p[9 + k] * cz
            over = abs(u) - p[12 + k]
            if over > most:
                most = over
                face = k
                side = ONE if u > ZERO else -ONE
        nx = side * p[3 + face]
        ny = side * p[6 + face]
        nz = side * p[9 + face]
    size = ONE / math.sqrt(max(nx * nx + ny * ny + nz * nz, TINY))
    return nx * size, ny * size, nz * size


@function
def lit(spheres, capsules, planes, boxes, x, y, z, lx, ly, lz, reach, skin):
    """1 where nothing solid stands between a point and a light at `reach` along the unit direction l, else 0.

    Points within `skin` under a surface count as on it, so that a root is not shaded by the solid that it grows from:
    only what a ray meets or is inside of after `skin` hides the light.
    """
    for s in range(spheres.shape[0]):
        if past_sphere(spheres[s], x, y, z, lx, ly, lz, reach, skin) == ZERO:
            return ZERO
    return past_others(capsules, planes, boxes, x, y, z, lx, ly, lz, reach, skin)


@function
def past_sphere(p, x, y, z, lx, ly, lz, reach, skin):
    """`lit` for one sphere, without branches."""
    cx = p[0] - x - skin * lx
    cy = p[1] - y - skin * ly
    cz = p[2] - z - skin * lz
    t = cx * lx + cy * ly + cz * lz
    left = (p[3] - skin) * (p[3] - skin) - (cx * cx + cy * cy + cz * cz - t * t)
    near = t - math.sqrt(max(left, ZERO))
    return ZERO if (t > ZERO) & (p[3] > skin) & (left > ZERO) & (near < reach) else ONE


@function
def past_others(capsules, planes, boxes, x, y, z, lx, ly, lz, reach, skin):
    """`lit` for all that are not spheres."""
    x += skin * lx
    y += skin * ly
    z += skin * lz
    for s in range(capsules.shape[0]):
        t = capsule(capsules[s], x, y, z, lx, ly, lz)
        if skin < t < reach:
            return ZERO
    for s in range(planes.shape[0]):
        t = plane(planes[s], x, y, z, lx, ly, lz)
        if skin < t < reach:
            return ZERO
    for s in range(boxes.shape[0]):
        t = box(boxes[s], x, y, z, lx, ly, lz)
        if skin < t < reach:
            return ZERO
    return ONE


@parallel
def draw(spheres, capsules, planes, boxes, frames, view, width, height, keys):
    """Fill the z-buffer with solids, and with `raster.EMPTY` where there are none.

    frames (m, 4) int64: for each solid the pixels it can touch, left, right, top, bottom (right and bottom not
    included); keys (height * width,) uint64. A row of a sphere is one loop without branches, which becomes vector code.
    """
    flat = ONE - view[12]
    far = ONE / view[19]
    for y in prange(height):
        row = keys[y * width : (y + 1) * width]
        row[:] = EMPTY
        up = (view[16] - np.float32(y) - HALF) / view[13]
        for m in range(frames.shape[0]):
            if y < frames[m, 2] or y >= frames[m, 3]:
                continue
            identity = FIRST + np.uint64(m)
            part = row[frames[m, 0] : frames[m, 1]]
            begin = np.float32(frames[m, 0]) + HALF - view[15]
            if m < spheres.shape[0]:
                p = spheres[m]
                for x in range(part.shape[0]):
                    ox, oy, oz, dx, dy, dz = ray(view, (begin + np.float32(x)) / view[13], up)
                    key = key_at(sphere(p, ox, oy, oz, dx, dy, dz), view, flat, far, identity)
                    part[x] = min(part[x], key)
            else:
                for x in range(part.shape[0]):
                    ox, oy, oz, dx, dy, dz = ray(view, (begin + np.float32(x)) / view[13], up)
                    t = meet(spheres, capsules, planes, boxes, m, ox, oy, oz, dx, dy, dz)
                    part[x] = min(part[x], key_at(t, view, flat, far, identity))


@function
def key_at(t, view, flat, far, identity):
    """The z-buffer's key of a solid at depth t, `raster.EMPTY` where t is not in front of the eye; flat: 1 for an
    orthographic view, far: one over its depth range."""
    # what lies behind an orthographic view's range is as far as its end
    q = (ONE - flat) / t + flat * max(ONE - (t - view[14]) * far, ZERO)
    key = ((LOW - np.uint64(np.float32(q).view(np.uint32))) << SHIFT) | identity
    return key if view[14] < t < INF else EMPTY


@function
def meet(spheres, capsules, planes, boxes, which, ox, oy, oz, dx, dy, dz):
    """Where a ray meets solid number `which`: its parameter, inf where it does not."""
    m = which
    if m < spheres.shape[0]:
        return sphere(spheres[m], ox, oy, oz, dx, dy, dz)
    m -= spheres.shape[0]
    if m < capsules.shape[0]:
        return capsule(capsules[m], ox, oy, oz, dx, dy, dz)
    m -= capsules.shape[0]
    if m < planes.shape[0]:
        return plane(planes[m], ox, oy, oz, dx, dy, dz)
    return box(boxes[m - planes.shape[0]], ox, oy, oz, dx, dy, dz)


@function
def ray(view, right, up):
    """Origin and direction of the ray through a point of the screen, (right, up) in metres at a depth of one metre; the
    direction's length is such that its parameter is the depth. No branch: view[12] is 1 for perspective, else 0."""
    ax = view[0] * right + view[4] * up
    ay = view[1] * right + view[5] * up
    az = view[2] * right + view[6] * up
    spread = view[12]
    shift = ONE - spread
    return (
        view[20] + shift * ax,
        view[21] + shift * ay,
        view[22] + shift * az,
        view[8] + spread * ax,
        view[9] + spread * ay,
        view[10] + spread * az,
    )
