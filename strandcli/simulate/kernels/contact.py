"""Contact of rods, edge by edge from root to tip: an edge that leads into a solid is turned until it does not.

The edge keeps its length, so its particle stays on a sphere about the one before it, and what is allowed of that sphere
is where the edge makes at least a certain angle with one axis: c = d·a may be at most some limit. For a ball about o,
with a toward o and D = |o − q|,

    the particle stays out        c <= (ℓ² + D² − r²) / (2 ℓ D)
    the whole edge stays out      c <= √(1 − r² / D²)   where it is long enough to reach the tangent point

and for a flat face with normal −a, c <= (height of q) / ℓ. Lengths stay exact and no penalty is involved. Friction is
Coulomb's on displacements: of the way that the particle slid along the surface in this step, friction times the depth
that it was lifted by is taken back.

Solids come packed as by `strandcli.solids.pack`, each row followed by 12 numbers: the rigid motion (rotation by rows,
translation) that took it through this step.
"""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import inner

LANES = np.uint64(W)
U2 = np.uint64(2)
ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
TINY = np.float32(1e-20)
ROUNDS = 3


@inner
def deepest(spheres, capsules, planes, boxes, x, y, z):
    """Depth of a point in the solid that it is deepest in (not positive: its distance from the nearest), that solid's
    kind (0 to 3, in the order of the arguments) and its number."""
    most = -ONE / TINY
    kind = 0
    which = 0
    for m in range(spheres.shape[0]):
        p = spheres[m]
        dx = x - p[0]
        dy = y - p[1]
        dz = z - p[2]
        d = p[3] - np.sqrt(dx * dx + dy * dy + dz * dz)
        if d > most:
            most = d
            which = m
    for m in range(capsules.shape[0]):
        p = capsules[m]
        ox, oy, oz = on_axis(p, x, y, z)
        dx = x - ox
        dy = y - oy
        dz = z - oz
        d = p[6] - np.sqrt(dx * dx + dy * dy + dz * dz)
        if d > most:
            most = d
            kind = 1
            which = m
    for m in range(planes.shape[0]):
        p = planes[m]
        d = p[3] - (x * p[0] + y * p[1] + z * p[2])
        if d > most:
            most = d
            kind = 2
            which = m
    for m in range(boxes.shape[0]):
        d = face(boxes[m], x, y, z)[0]
        if d > most:
            most = d
            kind = 3
            which = m
    return most, kind, which


@inner
def on_axis(p, x, y, z):
    """Point of a capsule's axis that is nearest to (x, y, z)."""
    t = min(max(((x - p[0]) * p[3] + (y - p[1]) * p[4] + (z - p[2]) * p[5]) * p[7], ZERO), ONE)
    return p[0] + t * p[3], p[1] + t * p[4], p[2] + t * p[5]


@inner
def face(p, x, y, z):
    """Depth in a box below its nearest face, and that face's normal in the world."""
    dx = x - p[0]
    dy = y - p[1]
    dz = z - p[2]
    best = ONE / TINY
    nx = ZERO
    ny = ONE
    nz = ZERO
    for k in range(3):
        u = p[3 + k] * dx + p[6 + k] * dy + p[9 + k] * dz
        under = p[12 + k] - abs(u)
        if under < best:
            best = under
            sign = ONE if u >= ZERO else -ONE
            nx = sign * p[3 + k]
            ny = sign * p[6 + k]
            nz = sign * p[9 + k]
    return best, nx, ny, nz


@inner
def along(p, qx, qy, qz, dx, dy, dz, length):
    """Share of an edge at which it is deepest in a box: the middle of the part that is inside, or 1."""
    enter = ZERO
    leave = ONE
    for k in range(3):
        q = p[3 + k] * (qx - p[0]) + p[6 + k] * (qy - p[1]) + p[9 + k] * (qz - p[2])
        d = length * (p[3 + k] * dx + p[6 + k] * dy + p[9 + k] * dz)
        if abs(d) < TINY:
            if abs(q) > p[12 + k]:
                return ONE
            continue
        a = (-p[12 + k] - q) / d
        b = (p[12 + k] - q) / d
        enter = max(enter, min(a, b))
        leave = min(leave, max(a, b))
    return HALF * (enter + leave) if leave > enter else ONE


@inner
def near_axis(p, qx, qy, qz, dx, dy, dz, length):
    """Point of a capsule's axis that is nearest to an edge (Ericson 2005, §5.1.9, by two alternating projections)."""
    t = ONE
    ox = qx
    oy = qy
    oz = qz
    for _ in range(4):
        ox, oy, oz = on_axis(p, qx + t * length * dx, qy + t * length * dy, qz + t * length * dz)
        t = ((ox - qx) * dx + (oy - qy) * dy + (oz - qz) * dz) / length
        t = min(max(t, ZERO), ONE)
    return ox, oy, oz


@inner
def bend(dx, dy, dz, ax, ay, az, limit):
    """Turn the unit vector d away from the unit vector a until d·a = limit, where it is more."""
    c = dx * ax + dy * ay + dz * az
    if c <= limit:
        return dx, dy, dz
    limit = max(limit, -ONE)
    nx = dx - c * ax
    ny = dy - c * ay
    nz = dz - c * az
    size = np.sqrt(nx * nx + ny * ny + nz * nz)
    if size < np.float32(1e-6):  # straight at it: any way round will do
        nx = ZERO if abs(ax) > HALF else ONE
        ny = ONE if abs(ax) > HALF else ZERO
        nz = ZERO
        c = nx * ax + ny * ay
        nx -= c * ax
        ny -= c * ay
        nz -= c * az
        size = np.sqrt(nx * nx + ny * ny + nz * nz)
    s = np.sqrt(max(ONE - limit * limit, ZERO)) / size
    return limit * ax + s * nx, limit * ay + s * ny, limit * az + s * nz


@inner
def off_ball(qx, qy, qz, dx, dy, dz, length, ox, oy, oz, r, whole):
    """Turn an edge off a ball."""
    ax = ox - qx
    ay = oy - qy
    az = oz - qz
    distance = np.sqrt(ax * ax + ay * ay + az * az)
    if distance < TINY:
        return dx, dy, dz
    ax /= distance
    ay /= distance
    az /= distance
    outside = distance * distance - r * r  # square of the tangent's length
    limit = (length * length + outside) / (TWO * length * distance)
    if whole and outside < length * length:
        # an edge from the surface itself is a tangent whichever way its beginning is rounded
        limit = min(limit, np.sqrt(max(outside, ZERO)) / distance)
    return bend(dx, dy, dz, ax, ay, az, limit)


@inner
def off_solids(qx, qy, qz, dx, dy, dz, length, spheres, capsules, planes, boxes, whole):
    """Turn an edge from q along d off every solid; overlapping ones take turns a few times."""
    for _ in range(ROUNDS):
        hx = dx
        hy = dy
        hz = dz
        for m in range(spheres.shape[0]):
            p = spheres[m]
            dx, dy, dz = off_ball(qx, qy, qz, dx, dy, dz, length, p[0], p[1], p[2], p[3], whole)
        for m in range(capsules.shape[0]):
            p = capsules[m]
            if whole:
                ox, oy, oz = near_axis(p, qx, qy, qz, dx, dy, dz, length)
                dx, dy, dz = off_ball(qx, qy, qz, dx, dy, dz, length, ox, oy, oz, p[6], True)
            ox, oy, oz = on_axis(p, qx + length * dx, qy + length * dy, qz + length * dz)
            dx, dy, dz = off_ball(qx, qy, qz, dx, dy, dz, length, ox, oy, oz, p[6], False)
        for m in range(boxes.shape[0]):
            p = boxes[m]
            t = along(p, qx, qy, qz, dx, dy, dz, length) if whole else ONE
            reach = t * length
            under, nx, ny, nz = face(p, qx + reach * dx, qy + reach * dy, qz + reach * dz)
            if under > ZERO and reach > TINY:
                # height of q over the face, from the depth of the point that is under it
                height = -under - reach * (dx * nx + dy * ny + dz * nz)
                dx, dy, dz = bend(dx, dy, dz, -nx, -ny, -nz, max(height / reach, -ONE))
        for m in range(planes.shape[0]):
            p = planes[m]
            height = qx * p[0] + qy * p[1] + qz * p[2] - p[3]
            dx, dy, dz = bend(dx, dy, dz, -p[0], -p[1], -p[2], max(height / length, -ONE))
        if hx == dx and hy == dy and hz == dz:
            break
    return dx, dy, dz


@inner
def carried(spheres, capsules, planes, boxes, x, y, z, ox, oy, oz):
    """Where the solid that is nearest to (x, y, z) has carried a point (ox, oy, oz) in this step, and its outward
    normal at (x, y, z)."""
    _, kind, which = deepest(spheres, capsules, planes, boxes, x, y, z)
    if kind == 0:
        p = spheres[which]
        o = 5
        nx = x - p[0]
        ny = y - p[1]
        nz = z - p[2]
    elif kind == 1:
        p = capsules[which]
        o = 9
        cx, cy, cz = on_axis(p, x, y, z)
        nx = x - cx
        ny = y - cy
        nz = z - cz
    elif kind == 2:
        p = planes[which]
        o = 4
        nx = p[0]
        ny = p[1]
        nz = p[2]
    else:
        p = boxes[which]
        o = 16
        _, nx, ny, nz = face(p, x, y, z)
    size = ONE / np.sqrt(max(nx * nx + ny * ny + nz * nz, TINY))
    tx = p[o] * ox + p[o + 1] * oy + p[o + 2] * oz + p[o + 9]
    ty = p[o + 3] * ox + p[o + 4] * oy + p[o + 5] * oz + p[o + 10]
    tz = p[o + 6] * ox + p[o + 7] * oy + p[o + 8] * oz + p[o + 11]
    return tx, ty, tz, nx * size, ny * size, nz * size


@inner
def touch(s, y, old, q, lengths, spheres, capsules, planes, boxes, whole, friction):
    """One edge of every lane: rows from y on of the scratch hold unit edges, rows from old on where the particles were
    before the step, rows from q on the particle before, in the world."""
    for k in range(LANES):
        length = lengths[k]
        qx = s[q + k]
        qy = s[q + LANES + k]
        qz = s[q + U2 * LANES + k]
        ex = s[y + k]
        ey = s[y + LANES + k]
        ez = s[y + U2 * LANES + k]
        px = qx + length * ex
        py = qy + length * ey
        pz = qz + length * ez
        if not whole and deepest(spheres, capsules, planes, boxes, px, py, pz)[0] <= ZERO:
            continue
        dx, dy, dz = off_solids(qx, qy, qz, ex, ey, ez, length, spheres, capsules, planes, boxes, whole)
        if friction > ZERO and (dx != ex or dy != ey or dz != ez):
            tx, ty, tz, nx, ny, nz = carried(
                spheres, capsules, planes, boxes, qx + length * dx, qy + length * dy, qz + length * dz,
                s[old + k], s[old + LANES + k], s[old + U2 * LANES + k],
            )  # fmt: skip
            lifted = length * abs((dx - ex) * nx + (dy - ey) * ny + (dz - ez) * nz)
            sx = qx + length * dx - tx
            sy = qy + length * dy - ty
            sz = qz + length * dz - tz
            away = sx * nx + sy * ny + sz * nz
            sx -= away * nx
            sy -= away * ny
            sz -= away * nz
            slid = np.sqrt(sx * sx + sy * sy + sz * sz)
            if slid > TINY:
                back = min(friction * lifted, slid) / (slid * length)
                x = dx - back * sx
                yy = dy - back * sy
                z = dz - back * sz
                size = ONE / np.sqrt(max(x * x + yy * yy + z * z, TINY))
                dx, dy, dz = off_solids(
                    qx, qy, qz, x * size, yy * size, z * size, length, spheres, capsules, planes, boxes, whole
                )
        s[y + k] = dx
        s[y + LANES + k] = dy
        s[y + U2 * LANES + k] = dz
