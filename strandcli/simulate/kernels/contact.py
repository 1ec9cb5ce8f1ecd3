"""Contact of rods, edge by edge from root to tip: an edge that leads into a solid is turned until it does not.

The edge keeps its length, so its particle stays on a sphere about the one before it, and what is allowed of that sphere
is where the edge makes at least a certain angle with one axis: c = d·a may be at most some limit. For a ball about o,
with a toward o and D = |o − q|,

    the particle stays out        c <= (ℓ² + D² − r²) / (2 ℓ D)
    the whole edge stays out      c <= √(1 − r² / D²)   where it is long enough to reach the tangent point

and for a flat face with normal −a, c <= (height of q) / ℓ. Lengths stay exact and no penalty is involved. Friction is
Coulomb's on displacements: of the way that the particle slid along the surface in this step, friction times the depth
that it was lifted by is taken back.

Coordinates are vectors of lanes; a solid that is out of every lane's reach costs no more than finding that out. Solids
come packed as by `strandcli.solids.pack`, each row followed by 12 numbers: the rigid motion (rotation by rows,
translation) that took it through this step. Solids of a kind are handed on as rows and how many numbers these hold, one
of them as rows and its place; all of them in the order spheres, capsules, planes, boxes.
"""

from __future__ import annotations

from ...jit import inner
from .simd import root, some, spread, where

TINY = 1e-20
LEAST = 1e-6
SPHERE, CAPSULE, PLANE, BOX = 17, 21, 16, 28
"""Numbers of a packed solid and its motion."""
ROUNDS = 3


@inner
def on_axis(capsules, m, x, y, z):
    """Point of a capsule's axis that is nearest to (x, y, z)."""
    ax, ay, az = capsules[m + 3], capsules[m + 4], capsules[m + 5]
    t = (x - capsules[m]) * ax + (y - capsules[m + 1]) * ay + (z - capsules[m + 2]) * az
    t = min(max(t * capsules[m + 7], 0.0), 1.0)
    return capsules[m] + t * ax, capsules[m + 1] + t * ay, capsules[m + 2] + t * az


@inner
def in_ball(dx, dy, dz, r):
    """Depth in a ball of a point that is (dx, dy, dz) away from its centre."""
    return r - root(dx * dx + dy * dy + dz * dz)


@inner
def in_capsule(capsules, m, x, y, z):
    """Depth of a point in a capsule."""
    ox, oy, oz = on_axis(capsules, m, x, y, z)
    return in_ball(x - ox, y - oy, z - oz, capsules[m + 6])


@inner
def under_plane(planes, m, x, y, z):
    """Depth of a point under a plane."""
    return planes[m + 3] - (x * planes[m] + y * planes[m + 1] + z * planes[m + 2])


@inner
def across(boxes, m, k, x, y, z):
    """Coordinate of a direction along an axis of a box."""
    return boxes[m + 3 + k] * x + boxes[m + 6 + k] * y + boxes[m + 9 + k] * z


@inner
def face(boxes, m, x, y, z):
    """Depth in a box below its nearest face, and that face's normal in the world."""
    dx = x - boxes[m]
    dy = y - boxes[m + 1]
    dz = z - boxes[m + 2]
    best = spread(x, 1.0 / TINY)
    nx = spread(x, 0.0)
    ny = spread(x, 1.0)
    nz = nx
    for k in range(3):
        u = across(boxes, m, k, dx, dy, dz)
        under = boxes[m + 12 + k] - abs(u)
        nearer = under < best
        best = where(nearer, under, best)
        sign = where(u >= 0.0, spread(x, 1.0), -1.0)
        nx = where(nearer, sign * boxes[m + 3 + k], nx)
        ny = where(nearer, sign * boxes[m + 6 + k], ny)
        nz = where(nearer, sign * boxes[m + 9 + k], nz)
    return best, nx, ny, nz


@inner
def along(boxes, m, qx, qy, qz, dx, dy, dz, length):
    """Share of an edge at which it is deepest in a box: the middle of the part that is inside, or 1."""
    enter = spread(qx, 0.0)
    leave = spread(qx, 1.0)
    for k in range(3):
        half = boxes[m + 12 + k]
        q = across(boxes, m, k, qx - boxes[m], qy - boxes[m + 1], qz - boxes[m + 2])
        d = length * across(boxes, m, k, dx, dy, dz)
        level = abs(d) < TINY
        over = 1.0 / where(level, 1.0, d)
        a = (-half - q) * over
        b = (half - q) * over
        beside = abs(q) > half
        enter = where(level, where(beside, 2.0, enter), max(enter, min(a, b)))
        leave = where(level, leave, min(leave, max(a, b)))
    return where(leave > enter, 0.5 * (enter + leave), 1.0)


@inner
def near_axis(capsules, m, qx, qy, qz, dx, dy, dz, length):
    """Point of a capsule's axis that is nearest to an edge (Ericson 2005, §5.1.9, by two alternating projections)."""
    t = length
    ox = qx
    oy = qy
    oz = qz
    for _ in range(4):
        ox, oy, oz = on_axis(capsules, m, qx + t * dx, qy + t * dy, qz + t * dz)
        t = (ox - qx) * dx + (oy - qy) * dy + (oz - qz) * dz
        t = min(max(t, 0.0), length)
    return ox, oy, oz


@inner
def bend(dx, dy, dz, ax, ay, az, limit):
    """Turn the unit vector d away from the unit vector a until d·a = limit, where it is more."""
    c = dx * ax + dy * ay + dz * az
    turn = c > limit
    if not some(turn):
        return dx, dy, dz
    limit = max(limit, -1.0)
    nx = dx - c * ax
    ny = dy - c * ay
    nz = dz - c * az
    size = root(nx * nx + ny * ny + nz * nz)
    lost = size < LEAST
    if some(lost):  # straight at it: any way round will do
        one = where(abs(ax) > 0.5, spread(ax, 0.0), 1.0)
        two = 1.0 - one
        c = one * ax + two * ay
        nx = where(lost, one - c * ax, nx)
        ny = where(lost, two - c * ay, ny)
        nz = where(lost, -c * az, nz)
        size = root(nx * nx + ny * ny + nz * nz)
    s = root(max(1.0 - limit * limit, 0.0)) / size
    x = where(turn, limit * ax + s * nx, dx)
    y = where(turn, limit * ay + s * ny, dy)
    return x, y, where(turn, limit * az + s * nz, dz)


@inner
def off_ball(qx, qy, qz, dx, dy, dz, length, ox, oy, oz, r, whole):
    """Turn an edge off a ball."""
    ax = ox - qx
    ay = oy - qy
    az = oz - qz
    square = ax * ax + ay * ay + az * az
    reach = length + r
    if not some(square < reach * reach):
        return dx, dy, dz
    distance = root(square)
    over = 1.0 / max(distance, TINY)
    outside = square - r * r  # square of the tangent's length
    limit = (length * length + outside) / (2.0 * length) * over
    if whole:
        # an edge from the surface itself is a tangent whichever way its beginning is rounded
        tangent = min(limit, root(max(outside, 0.0)) * over)
        limit = where(outside < length * length, tangent, limit)
    limit = where(distance < TINY, 1.0 / TINY, limit)
    return bend(dx, dy, dz, ax * over, ay * over, az * over, limit)


@inner
def off_capsule(qx, qy, qz, dx, dy, dz, length, capsules, m, whole):
    """Turn an edge off a capsule: off the ball about the point of its axis that is nearest."""
    r = capsules[m + 6]
    ox, oy, oz = on_axis(capsules, m, qx, qy, qz)
    x = ox - qx
    y = oy - qy
    z = oz - qz
    reach = length + r
    if not some(x * x + y * y + z * z < reach * reach):
        return dx, dy, dz
    if whole:
        ox, oy, oz = near_axis(capsules, m, qx, qy, qz, dx, dy, dz, length)
        dx, dy, dz = off_ball(qx, qy, qz, dx, dy, dz, length, ox, oy, oz, r, True)
    ox, oy, oz = on_axis(capsules, m, qx + length * dx, qy + length * dy, qz + length * dz)
    return off_ball(qx, qy, qz, dx, dy, dz, length, ox, oy, oz, r, False)


@inner
def off_box(qx, qy, qz, dx, dy, dz, length, boxes, m, whole):
    """Turn an edge off the face of a box that is nearest to its deepest point."""
    beyond = spread(qx, -1.0 / TINY)
    for k in range(3):
        u = across(boxes, m, k, qx - boxes[m], qy - boxes[m + 1], qz - boxes[m + 2])
        beyond = max(beyond, abs(u) - boxes[m + 12 + k])
    if not some(beyond < length):
        return dx, dy, dz
    reach = length
    if whole:
        reach = along(boxes, m, qx, qy, qz, dx, dy, dz, length) * length
    under, nx, ny, nz = face(boxes, m, qx + reach * dx, qy + reach * dy, qz + reach * dz)
    # height of q over the face, from the depth of the point that is under it
    height = -under - reach * (dx * nx + dy * ny + dz * nz)
    inside = (under > 0.0) & (reach > TINY)
    limit = where(inside, max(height / max(reach, TINY), -1.0), 1.0 / TINY)
    return bend(dx, dy, dz, -nx, -ny, -nz, limit)


@inner
def off_solids(qx, qy, qz, dx, dy, dz, length, solids, whole):
    """Turn an edge from q along d off every solid; overlapping ones take turns a few times."""
    (spheres, last_sphere), (capsules, last_capsule), (planes, last_plane), (boxes, last_box) = solids
    for _ in range(ROUNDS):
        hx = dx
        hy = dy
        hz = dz
        for m in range(0, last_sphere, SPHERE):
            ox, oy, oz = spread(qx, spheres[m]), spread(qx, spheres[m + 1]), spread(qx, spheres[m + 2])
            dx, dy, dz = off_ball(qx, qy, qz, dx, dy, dz, length, ox, oy, oz, spheres[m + 3], whole)
        for m in range(0, last_capsule, CAPSULE):
            dx, dy, dz = off_capsule(qx, qy, qz, dx, dy, dz, length, capsules, m, whole)
        for m in range(0, last_box, BOX):
            dx, dy, dz = off_box(qx, qy, qz, dx, dy, dz, length, boxes, m, whole)
        for m in range(0, last_plane, PLANE):
            limit = max(-under_plane(planes, m, qx, qy, qz) / length, -1.0)
            nx, ny, nz = spread(qx, -planes[m]), spread(qx, -planes[m + 1]), spread(qx, -planes[m + 2])
            dx, dy, dz = bend(dx, dy, dz, nx, ny, nz, limit)
        if not some((hx != dx) | (hy != dy) | (hz != dz)):
            break
    return dx, dy, dz


@inner
def motion(solids, o, x, y, z):
    """Where a solid, whose motion is in columns from o on, has carried a point in this step."""
    return (
        solids[o] * x + solids[o + 1] * y + solids[o + 2] * z + solids[o + 9],
        solids[o + 3] * x + solids[o + 4] * y + solids[o + 5] * z + solids[o + 10],
        solids[o + 6] * x + solids[o + 7] * y + solids[o + 8] * z + solids[o + 11],
    )


@inner
def choose(nearer, one, other):
    """Six vectors: of ``one`` where a mask holds."""
    a, b, c, d, e, f = one
    g, h, i, j, k, m = other
    return (
        where(nearer, a, g), where(nearer, b, h), where(nearer, c, i),
        where(nearer, d, j), where(nearer, e, k), where(nearer, f, m),
    )  # fmt: skip


@inner
def carried(solids, x, y, z, ox, oy, oz):
    """Where the solid that is nearest to (x, y, z) has carried a point (ox, oy, oz) in this step, and its outward
    normal at (x, y, z)."""
    (spheres, last_sphere), (capsules, last_capsule), (planes, last_plane), (boxes, last_box) = solids
    most = spread(x, -1.0 / TINY)
    found = (x, x, x, x, x, x)
    for m in range(0, last_sphere, SPHERE):
        nx, ny, nz = x - spheres[m], y - spheres[m + 1], z - spheres[m + 2]
        d = in_ball(nx, ny, nz, spheres[m + 3])
        if some(d > most):
            found = choose(d > most, (*motion(spheres, m + 5, ox, oy, oz), nx, ny, nz), found)
            most = max(most, d)
    for m in range(0, last_capsule, CAPSULE):
        cx, cy, cz = on_axis(capsules, m, x, y, z)
        nx, ny, nz = x - cx, y - cy, z - cz
        d = in_ball(nx, ny, nz, capsules[m + 6])
        if some(d > most):
            found = choose(d > most, (*motion(capsules, m + 9, ox, oy, oz), nx, ny, nz), found)
            most = max(most, d)
    for m in range(0, last_plane, PLANE):
        d = under_plane(planes, m, x, y, z)
        if some(d > most):
            nx, ny, nz = spread(x, planes[m]), spread(x, planes[m + 1]), spread(x, planes[m + 2])
            found = choose(d > most, (*motion(planes, m + 4, ox, oy, oz), nx, ny, nz), found)
            most = max(most, d)
    for m in range(0, last_box, BOX):
        d, nx, ny, nz = face(boxes, m, x, y, z)
        if some(d > most):
            found = choose(d > most, (*motion(boxes, m + 16, ox, oy, oz), nx, ny, nz), found)
            most = max(most, d)
    tx, ty, tz, nx, ny, nz = found
    size = 1.0 / root(max(nx * nx + ny * ny + nz * nz, TINY))
    return tx, ty, tz, nx * size, ny * size, nz * size


@inner
def touch(ex, ey, ez, qx, qy, qz, ox, oy, oz, length, solids, whole, friction):
    """The unit edge e from q, turned off all solids; its particle was at o before the step."""
    dx, dy, dz = off_solids(qx, qy, qz, ex, ey, ez, length, solids, whole)
    turned = (dx != ex) | (dy != ey) | (dz != ez)
    if not (friction > 0.0 and some(turned)):
        return dx, dy, dz
    px = qx + length * dx
    py = qy + length * dy
    pz = qz + length * dz
    tx, ty, tz, nx, ny, nz = carried(solids, px, py, pz, ox, oy, oz)
    lifted = length * abs((dx - ex) * nx + (dy - ey) * ny + (dz - ez) * nz)
    sx = px - tx
    sy = py - ty
    sz = pz - tz
    away = sx * nx + sy * ny + sz * nz
    sx -= away * nx
    sy -= away * ny
    sz -= away * nz
    slid = root(sx * sx + sy * sy + sz * sz)
    turned = turned & (slid > TINY)
    if not some(turned):
        return dx, dy, dz
    back = min(friction * lifted, slid) / (max(slid, TINY) * length)
    x = dx - back * sx
    y = dy - back * sy
    z = dz - back * sz
    size = 1.0 / root(max(x * x + y * y + z * z, TINY))
    x, y, z = off_solids(qx, qy, qz, x * size, y * size, z * size, length, solids, whole)
    return where(turned, x, dx), where(turned, y, dy), where(turned, z, dz)
