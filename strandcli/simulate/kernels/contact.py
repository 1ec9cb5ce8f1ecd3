"""Contact of rods, edge by edge from root to tip: an edge that leads into a solid is turned until it does not.

The edge keeps its length, so its particle stays on a sphere about the one before it, and what is allowed of that sphere
is where the edge makes at least a certain angle with one axis: c = d·a may be at most some limit. For a ball about o,
with a toward o and D = |o − q|, the particle stays out where c <= (ℓ² + D² − r²) / (2 ℓ D), and for a flat face with
normal −a where c <= (height of q) / ℓ. Lengths stay exact and no penalty is involved.

Force. Newton's iterations come before this and would bend a strand that leans on a solid as if nothing were there; what
is left of that after turning edges depends on the step. So the force of contact is kept from step to step, as the
acceleration of the particle that it acts on, and takes part in the iterations (the multiplier of an augmented
Lagrangian, updated once a step: Nocedal & Wright 2006, §17.3). A particle that comes to lie at depth δ, where the force
of the step before came to λ, has

    λ' = max(0, λ + w δ),  held at the surface where λ' > 0, set free from λ where not,

and across the normal the same with the way that it slid, no more than friction times λ' (Coulomb's law). Both are
displacements, forces times h²; w is how much heavier than the particle all is that such forces on the strand move: with
H of the iterations and χ = 1 where there are forces, 1 / w = H⁻¹ M χ, a bound on the row sums of what forces lead to,
so that updates at once of all do not overshoot. At rest δ = 0, and a strand leans on a solid just as it would at any
other step. Of an impact, the depth that comes from velocity alone, is no force kept.

Where whole edges are caught, each particle stays far enough from a ball that the halves of its edges do, too, as they
lie: r² + s² where s is how far along the half the ball is nearest. No edge is a lever that way. The first edge, whose
root cannot give way, is turned until it is a tangent, c <= √(1 − r² / D²).

Solids come packed as by `strandcli.solids.pack`, each row followed by 12 numbers: the rigid motion (rotation by rows,
translation) that took it through this step.
"""

from __future__ import annotations

import numpy as np

from ...jit import inner
from .rod import BULK, GRIP, HALF, HELD, HIT, LANES, OLD, ONE, PLACE, SEGMENT, TWO, U2, ZERO, E, Y

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
def inner_part(p, x, y, z, dx, dy, dz, reach):
    """How far along a line from (x, y, z) it is deepest in a box: the middle of what is inside up to ``reach``, or 0."""
    enter = ZERO
    leave = reach
    for k in range(3):
        q = p[3 + k] * (x - p[0]) + p[6 + k] * (y - p[1]) + p[9 + k] * (z - p[2])
        d = p[3 + k] * dx + p[6 + k] * dy + p[9 + k] * dz
        if abs(d) < TINY:
            if abs(q) > p[12 + k]:
                return ZERO
            continue
        a = (-p[12 + k] - q) / d
        b = (p[12 + k] - q) / d
        enter = max(enter, min(a, b))
        leave = min(leave, max(a, b))
    return HALF * (enter + leave) if leave > enter else ZERO


@inner
def ball_at(x, y, z, ox, oy, oz, r, edge, next, half):
    """Radius about o that keeps a particle at (x, y, z) and the halves of its edges off a ball; ``edge`` the unit
    vector to it, ``next`` the one from it on."""
    x -= ox
    y -= oy
    z -= oz
    foot = max(x * edge[0] + y * edge[1] + z * edge[2], -(x * next[0] + y * next[1] + z * next[2]))
    foot = min(max(foot, ZERO), half)
    return np.sqrt(r * r + foot * foot)


@inner
def on_axis_for(p, x, y, z, edge, next, half):
    """Point of a capsule's axis that is nearest to the halves of a particle's edges, by alternating projections."""
    ox, oy, oz = on_axis(p, x, y, z)
    if half > ZERO:
        for _ in range(2):
            back = (x - ox) * edge[0] + (y - oy) * edge[1] + (z - oz) * edge[2]
            on = -((x - ox) * next[0] + (y - oy) * next[1] + (z - oz) * next[2])
            if back > on:
                t = min(max(back, ZERO), half)
                ox, oy, oz = on_axis(p, x - t * edge[0], y - t * edge[1], z - t * edge[2])
            else:
                t = min(max(on, ZERO), half)
                ox, oy, oz = on_axis(p, x + t * next[0], y + t * next[1], z + t * next[2])
    return ox, oy, oz


@inner
def face_for(p, x, y, z, edge, next, half):
    """Depth of a particle below a face of a box, as much as takes the halves of its edges out, too, and the normal."""
    under, nx, ny, nz = face(p, x, y, z)
    if half > ZERO:
        t = inner_part(p, x, y, z, -edge[0], -edge[1], -edge[2], half)
        if t > ZERO:
            d, ax, ay, az = face(p, x - t * edge[0], y - t * edge[1], z - t * edge[2])
            if d > under:
                under, nx, ny, nz = d, ax, ay, az
        t = inner_part(p, x, y, z, next[0], next[1], next[2], half)
        if t > ZERO:
            d, ax, ay, az = face(p, x + t * next[0], y + t * next[1], z + t * next[2])
            if d > under:
                under, nx, ny, nz = d, ax, ay, az
    return under, nx, ny, nz


@inner
def nearest(spheres, capsules, planes, boxes, x, y, z, edge, next, half):
    """The solid that a particle is deepest in, or nearest to: its depth, kind (0 to 3, in the order of the arguments)
    and number; then a ball's centre and radius, or of a flat face the normal and how far along it the particle is to
    be."""
    most = -ONE / TINY
    kind = 0
    which = 0
    ox, oy, oz, r = ZERO, ZERO, ZERO, ZERO
    for m in range(spheres.shape[0]):
        p = spheres[m]
        a, b, c = p[0], p[1], p[2]
        reach = ball_at(x, y, z, a, b, c, p[3], edge, next, half)
        d = reach - np.sqrt((x - a) * (x - a) + (y - b) * (y - b) + (z - c) * (z - c))
        if d > most:
            most, which, ox, oy, oz, r = d, m, a, b, c, reach
    for m in range(capsules.shape[0]):
        p = capsules[m]
        a, b, c = on_axis_for(p, x, y, z, edge, next, half)
        reach = ball_at(x, y, z, a, b, c, p[6], edge, next, half)
        d = reach - np.sqrt((x - a) * (x - a) + (y - b) * (y - b) + (z - c) * (z - c))
        if d > most:
            most, kind, which, ox, oy, oz, r = d, 1, m, a, b, c, reach
    for m in range(planes.shape[0]):
        p = planes[m]
        d = p[3] - (x * p[0] + y * p[1] + z * p[2])
        if d > most:
            most, kind, which, ox, oy, oz, r = d, 2, m, p[0], p[1], p[2], p[3]
    for m in range(boxes.shape[0]):
        d, a, b, c = face_for(boxes[m], x, y, z, edge, next, half)
        if d > most:
            most, kind, which, ox, oy, oz, r = d, 3, m, a, b, c, d + x * a + y * b + z * c
    return most, kind, which, ox, oy, oz, r


@inner
def bend(dx, dy, dz, ax, ay, az, limit):
    """Turn the unit vector d toward the unit vector a, or away from it, until d·a = limit."""
    limit = min(max(limit, -ONE), ONE)
    c = dx * ax + dy * ay + dz * az
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
def onto(qx, qy, qz, d, length, round, ox, oy, oz, r):
    """Turn an edge from q along d until its end is on a ball, or a plane where not ``round``."""
    if not round:
        height = qx * ox + qy * oy + qz * oz - r
        return bend(d[0], d[1], d[2], -ox, -oy, -oz, height / length)
    ax = ox - qx
    ay = oy - qy
    az = oz - qz
    away = np.sqrt(ax * ax + ay * ay + az * az)
    if away < TINY:
        return d
    limit = (length * length + (away - r) * (away + r)) / (TWO * length * away)
    return bend(d[0], d[1], d[2], ax / away, ay / away, az / away, limit)


@inner
def off_solids(qx, qy, qz, d, next, length, half, spheres, capsules, planes, boxes):
    """Turn an edge from q along d off every solid; overlapping ones take turns a few times."""
    for _ in range(ROUNDS):
        depth, kind, _, ox, oy, oz, r = nearest(
            spheres, capsules, planes, boxes, qx + length * d[0], qy + length * d[1], qz + length * d[2], d, next, half
        )
        if depth <= ZERO:
            break
        d = onto(qx, qy, qz, d, length, kind < 2, ox, oy, oz, r)
    return d


@inner
def off_root(qx, qy, qz, d, length, spheres, capsules):
    """Turn an edge from the root along d until it is not inside a ball anywhere."""
    for m in range(spheres.shape[0]):
        p = spheres[m]
        d = tangent(qx, qy, qz, d, length, p[0], p[1], p[2], p[3])
    for m in range(capsules.shape[0]):
        p = capsules[m]
        t = length
        ox, oy, oz = qx, qy, qz
        for _ in range(4):
            ox, oy, oz = on_axis(p, qx + t * d[0], qy + t * d[1], qz + t * d[2])
            t = min(max((ox - qx) * d[0] + (oy - qy) * d[1] + (oz - qz) * d[2], ZERO), length)
        d = tangent(qx, qy, qz, d, length, ox, oy, oz, p[6])
    return d


@inner
def tangent(qx, qy, qz, d, length, ox, oy, oz, r):
    """Turn an edge from q along d away from a ball about o until it is a tangent, where the edge reaches that far. One
    from the surface itself is a tangent whichever way its beginning is rounded."""
    ax = ox - qx
    ay = oy - qy
    az = oz - qz
    away = np.sqrt(ax * ax + ay * ay + az * az)
    outside = (away - r) * (away + r)  # square of the tangent's length
    if away < TINY or outside >= length * length:
        return d
    limit = np.sqrt(max(outside, ZERO)) / away
    if d[0] * ax + d[1] * ay + d[2] * az <= limit * away:
        return d
    return bend(d[0], d[1], d[2], ax / away, ay / away, az / away, limit)


@inner
def motion(spheres, capsules, planes, boxes, kind, which, x, y, z):
    """Where a solid has carried a point in this step."""
    if kind == 0:
        p = spheres[which]
        o = 5
    elif kind == 1:
        p = capsules[which]
        o = 9
    elif kind == 2:
        p = planes[which]
        o = 4
    else:
        p = boxes[which]
        o = 16
    tx = p[o] * x + p[o + 1] * y + p[o + 2] * z + p[o + 9]
    ty = p[o + 3] * x + p[o + 4] * y + p[o + 5] * z + p[o + 10]
    tz = p[o + 6] * x + p[o + 7] * y + p[o + 8] * z + p[o + 11]
    return tx, ty, tz


@inner
def touch(s, o, lengths, velocity, push, j, beat, over, spheres, capsules, planes, boxes, whole, friction):
    """One edge of every lane, as `rod_contact.touch_ball`. Returns whether there are forces."""
    found = False
    for v in range(LANES):
        k = o + v
        length = lengths[v]
        half = HALF * length if whole else ZERO
        q = k - SEGMENT + PLACE
        qx = s[q]
        qy = s[q + LANES]
        qz = s[q + U2 * LANES]
        d = (s[k + Y], s[k + Y + LANES], s[k + Y + U2 * LANES])
        next = (s[k + SEGMENT + E], s[k + SEGMENT + E + LANES], s[k + SEGMENT + E + U2 * LANES])
        if whole and j == 0:
            d = off_root(qx, qy, qz, d, length, spheres, capsules)
        x = qx + length * d[0]
        y = qy + length * d[1]
        z = qz + length * d[2]
        depth, kind, which, ox, oy, oz, r = nearest(spheres, capsules, planes, boxes, x, y, z, d, next, half)
        held = s[k + GRIP] > ZERO
        bulk = ONE
        hx = ZERO
        hy = ZERO
        hz = ZERO
        if held:
            bulk = s[k + BULK]
            hx = s[k + HELD]
            hy = s[k + HELD + LANES]
            hz = s[k + HELD + U2 * LANES]
        elif depth <= ZERO:
            s[k + Y], s[k + Y + LANES], s[k + Y + U2 * LANES] = d
            continue
        nx, ny, nz = (x - ox, y - oy, z - oz) if kind < 2 else (ox, oy, oz)
        f = ONE / np.sqrt(max(nx * nx + ny * ny + nz * nz, TINY))
        force = f * max(hx * nx + hy * ny + hz * nz, ZERO) + bulk * depth
        if force <= ZERO:  # set free
            f = ONE / bulk
            d = unit(length * d[0] - f * hx, length * d[1] - f * hy, length * d[2] - f * hz)
            d = off_solids(qx, qy, qz, d, next, length, half, spheres, capsules, planes, boxes)
            s[k + Y], s[k + Y + LANES], s[k + Y + U2 * LANES] = d
            continue
        d = onto(qx, qy, qz, d, length, kind < 2, ox, oy, oz, r)
        d = off_solids(qx, qy, qz, d, next, length, half, spheres, capsules, planes, boxes)
        x = qx + length * d[0]
        y = qy + length * d[1]
        z = qz + length * d[2]
        if kind < 2:
            nx, ny, nz = unit(x - ox, y - oy, z - oz)
        px = s[k + OLD]
        py = s[k + OLD + LANES]
        pz = s[k + OLD + U2 * LANES]
        tx, ty, tz = motion(spheres, capsules, planes, boxes, kind, which, px, py, pz)
        f = hx * nx + hy * ny + hz * nz
        hx -= f * nx
        hy -= f * ny
        hz -= f * nz
        f = (x - tx) * nx + (y - ty) * ny + (z - tz) * nz
        fx = hx - bulk * (x - tx - f * nx)
        fy = hy - bulk * (y - ty - f * ny)
        fz = hz - bulk * (z - tz - f * nz)
        f = min(friction * force / np.sqrt(max(fx * fx + fy * fy + fz * fz, TINY)), ONE)
        fx *= f
        fy *= f
        fz *= f
        if friction > ZERO or held:
            f = ONE / bulk
            d = unit(length * d[0] + f * (fx - hx), length * d[1] + f * (fy - hy), length * d[2] + f * (fz - hz))
            d = onto(qx, qy, qz, d, length, kind < 2, ox, oy, oz, r)
            d = off_solids(qx, qy, qz, d, next, length, half, spheres, capsules, planes, boxes)
        f = ONE
        if not held:  # an impact is no force that stays
            s[HIT + v] = ONE
            f = nx * (tx - px - beat * velocity[j, v]) + ny * (ty - py - beat * velocity[j, LANES + v])
            f += nz * (tz - pz - beat * velocity[j, U2 * LANES + v])
            f = max(depth - max(f, ZERO), ZERO) / depth
        f *= over
        push[j, v] = f * (fx + force * nx)
        push[j, LANES + v] = f * (fy + force * ny)
        push[j, U2 * LANES + v] = f * (fz + force * nz)
        s[k + Y], s[k + Y + LANES], s[k + Y + U2 * LANES] = d
        found = True
    return found


@inner
def unit(x, y, z):
    """A vector scaled to length 1."""
    f = ONE / np.sqrt(max(x * x + y * y + z * z, TINY))
    return f * x, f * y, f * z
