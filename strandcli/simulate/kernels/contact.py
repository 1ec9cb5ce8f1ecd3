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
so that all may be updated at once without overshoot. At rest δ = 0, and a strand leans on a solid just as it would at
any other step. The depth that comes of velocity alone, an impact, is no force kept.

Where whole edges are caught, each particle stays far enough from a solid that the near halves of its edges do, as they
lie: √(r² + s²) from a ball, where s is how far along a half it is nearest. So no edge is a lever that a touch near its
beginning would throw up. Of the first edge, whose root cannot give way, the particle takes care of all.

Coordinates are vectors of lanes; a solid that is out of every lane's reach costs no more than finding that out. Solids
come packed as by `strandcli.solids.pack`, each row followed by 12 numbers: the rigid motion (rotation by rows,
translation) that took it through this step. Solids of a kind are handed on as rows and how many numbers these hold, one
of them as rows and its place; all of them in the order spheres, capsules, planes, boxes.
"""

from __future__ import annotations

from ...jit import inlined, inner
from .simd import root, some, spread, where

TINY = 1e-20
LEAST = 1e-6
SLACK = 1e-6
"""Depth as a share of an edge that is no more than rounding."""
SPHERE, CAPSULE, PLANE, BOX = 17, 21, 16, 28
"""Numbers of a packed solid and its motion."""
ROUNDS = 3


@inlined
def on_axis(capsules, m, x, y, z):
    """Point of a capsule's axis that is nearest to (x, y, z)."""
    ax, ay, az = capsules[m + 3], capsules[m + 4], capsules[m + 5]
    t = (x - capsules[m]) * ax + (y - capsules[m + 1]) * ay + (z - capsules[m + 2]) * az
    t = min(max(t * capsules[m + 7], 0.0), 1.0)
    return capsules[m] + t * ax, capsules[m + 1] + t * ay, capsules[m + 2] + t * az


@inlined
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
def cut(boxes, m, x, y, z, dx, dy, dz, reach):
    """How deep a line from (x, y, z) on is in a box within ``reach``, and the direction in which that is. One that
    enters by a face F and leaves by a face G cuts off an edge of the box; the way out is across both the line and that
    edge, |d·G| F + |d·F| G. One that has passed G before it comes to F goes by the edge, at a negative depth. One that
    leaves by the opposite face, or not at all, is led out by the nearest face. -1 / TINY: neither of them."""
    zero = spread(x, 0.0)
    enter = zero
    leave = reach
    f = zero
    g = zero
    ax, ay, az = zero, zero, zero
    bx, by, bz = zero, zero, zero
    for k in range(3):
        half = boxes[m + 12 + k]
        q = across(boxes, m, k, x - boxes[m], y - boxes[m + 1], z - boxes[m + 2])
        d = across(boxes, m, k, dx, dy, dz)
        size = max(abs(d), TINY)
        way = where(d < 0.0, spread(x, -1.0), 1.0)
        begin = -(half + way * q) / size
        end = (half - way * q) / size
        later = begin > enter
        enter = max(enter, begin)
        f = where(later, size, f)
        ax = where(later, -way * boxes[m + 3 + k], ax)
        ay = where(later, -way * boxes[m + 6 + k], ay)
        az = where(later, -way * boxes[m + 9 + k], az)
        sooner = end < leave
        leave = min(leave, end)
        g = where(sooner, size, g)
        bx = where(sooner, way * boxes[m + 3 + k], bx)
        by = where(sooner, way * boxes[m + 6 + k], by)
        bz = where(sooner, way * boxes[m + 9 + k], bz)
    inside = leave > enter
    if not some(inside | ((f > 0.0) & (g > 0.0))):
        return spread(x, -1.0 / TINY), zero, zero, zero
    nx = g * ax + f * bx
    ny = g * ay + f * by
    nz = g * az + f * bz
    size = root(nx * nx + ny * ny + nz * nz)
    edge = size > LEAST
    over = 1.0 / max(size, LEAST)
    depth = (leave - enter) * f * g * over
    nx *= over
    ny *= over
    nz *= over
    if some(inside & ~edge):
        t = where(g > 0.0, 0.5 * (enter + leave), leave)
        d, ax, ay, az = face(boxes, m, x + t * dx, y + t * dy, z + t * dz)
        depth = where(edge, depth, d)
        nx = where(edge, nx, ax)
        ny = where(edge, ny, ay)
        nz = where(edge, nz, az)
    return where(inside | edge, depth, -1.0 / TINY), nx, ny, nz


@inlined
def foot(x, y, z, edge, next, half):
    """How far back along a particle's edge it is nearest to a point that the particle is (x, y, z) away from, and how
    far on along the next one; no further than ``half``."""
    back = min(max(x * edge[0] + y * edge[1] + z * edge[2], 0.0), half)
    on = min(max(-(x * next[0] + y * next[1] + z * next[2]), 0.0), half)
    return back, on


@inlined
def kept_from(dx, dy, dz, r, edge, next, length, whole, first):
    """Radius that keeps a particle, (dx, dy, dz) away from the centre, off a ball, and the halves of its edges, too. Of
    the first edge all: up to its end it goes on for what is left of it from the tangent point."""
    if not whole:
        return spread(dx, r)
    back, on = foot(dx, dy, dz, edge, next, 0.5 * length)
    if first:
        x = dx - length * edge[0]
        y = dy - length * edge[1]
        z = dz - length * edge[2]
        back = max(length - root(max(x * x + y * y + z * z - r * r, 0.0)), 0.0)
    s = max(back, on)
    return root(s * s + r * r)


@inner
def toward_axis(capsules, m, x, y, z, ox, oy, oz, edge, next, lever):
    """Point of a capsule's axis that is nearest to a particle's edges up to ``lever`` away from it, begun with the one
    that is nearest to the particle: by alternating projections."""
    for _ in range(2):
        back, on = foot(x - ox, y - oy, z - oz, edge, next, lever)
        behind = back > on
        back = where(behind, back, 0.0)
        on = where(behind, 0.0, on)
        ox, oy, oz = on_axis(
            capsules, m, x - back * edge[0] + on * next[0], y - back * edge[1] + on * next[1],
            z - back * edge[2] + on * next[2],
        )  # fmt: skip
    return ox, oy, oz


@inner
def deeper(one, other):
    """Of two ways out of a box, (depth, normal) each, the longer one."""
    a = one[0] > other[0]
    return (
        max(one[0], other[0]), where(a, one[1], other[1]), where(a, one[2], other[2]), where(a, one[3], other[3]),
    )  # fmt: skip


@inner
def past_edge(boxes, m, x, y, z, under, edge, next, lever, length, far):
    """`face`, which found a particle ``under`` it, or where it is outside how deep the near parts of its edges are, if
    no further away than ``far``."""
    out = under[0] <= 0.0
    back = cut(boxes, m, x, y, z, -edge[0], -edge[1], -edge[2], lever)
    depth, nx, ny, nz = deeper(back, cut(boxes, m, x, y, z, next[0], next[1], next[2], 0.5 * length))
    return deeper((where(out & (depth > -far), depth, -1.0 / TINY), nx, ny, nz), under)


@inlined
def nearest(x, y, z, edge, next, length, old, reach, solids, whole, first):
    """The solid that a particle at (x, y, z) is deepest in, or nearest to and no further than ``reach``: the depth; 1
    where it is round there and 0 where flat; the centre and radius, or of a flat face the normal and how far along that
    the particle has to be; where it has carried the place ``old`` in this step. A depth of -reach: there is none."""
    (spheres, last_sphere), (capsules, last_capsule), (planes, last_plane), (boxes, last_box) = solids
    most = -reach
    round = spread(x, 0.0)
    found = (round, round, round, round, round, round, round)
    lever = round  # how far the nearest place of an edge may be from the particle
    if whole:
        lever = length if first else 0.5 * length
    for m in range(0, last_sphere, SPHERE):
        dx, dy, dz = x - spheres[m], y - spheres[m + 1], z - spheres[m + 2]
        far = spheres[m + 3] + lever - most
        if some(dx * dx + dy * dy + dz * dz < far * abs(far)):
            r = kept_from(dx, dy, dz, spheres[m + 3], edge, next, length, whole, first)
            d = in_ball(dx, dy, dz, r)
            ox, oy, oz = spread(x, spheres[m]), spread(x, spheres[m + 1]), spread(x, spheres[m + 2])
            found = choose(d > most, (ox, oy, oz, r, *motion(spheres, m + 5, old)), found)
            round = where(d > most, 1.0, round)
            most = max(most, d)
    for m in range(0, last_capsule, CAPSULE):
        ox, oy, oz = on_axis(capsules, m, x, y, z)
        dx, dy, dz = x - ox, y - oy, z - oz
        far = capsules[m + 6] + lever - most
        if some(dx * dx + dy * dy + dz * dz < far * abs(far)):
            if whole:
                ox, oy, oz = toward_axis(capsules, m, x, y, z, ox, oy, oz, edge, next, lever)
            r = kept_from(x - ox, y - oy, z - oz, capsules[m + 6], edge, next, length, whole, first)
            d = in_ball(x - ox, y - oy, z - oz, r)
            found = choose(d > most, (ox, oy, oz, r, *motion(capsules, m + 9, old)), found)
            round = where(d > most, 1.0, round)
            most = max(most, d)
    for m in range(0, last_plane, PLANE):
        d = under_plane(planes, m, x, y, z)
        if some(d > most):
            ox, oy, oz = spread(x, planes[m]), spread(x, planes[m + 1]), spread(x, planes[m + 2])
            found = choose(d > most, (ox, oy, oz, spread(x, planes[m + 3]), *motion(planes, m + 4, old)), found)
            round = where(d > most, 0.0, round)
            most = max(most, d)
    for m in range(0, last_box, BOX):
        d, ox, oy, oz = face(boxes, m, x, y, z)
        if some(d + lever > most):
            if whole:
                d, ox, oy, oz = past_edge(boxes, m, x, y, z, (d, ox, oy, oz), edge, next, lever, length, reach)
            level = d + x * ox + y * oy + z * oz
            found = choose(d > most, (ox, oy, oz, level, *motion(boxes, m + 16, old)), found)
            round = where(d > most, 0.0, round)
            most = max(most, d)
    return most, round > 0.0, found


@inlined
def motion(solids, o, point):
    """Where a solid, whose motion is in columns from o on, has carried a point in this step."""
    x, y, z = point
    return (
        solids[o] * x + solids[o + 1] * y + solids[o + 2] * z + solids[o + 9],
        solids[o + 3] * x + solids[o + 4] * y + solids[o + 5] * z + solids[o + 10],
        solids[o + 6] * x + solids[o + 7] * y + solids[o + 8] * z + solids[o + 11],
    )


@inlined
def choose(nearer, one, other):
    """Seven vectors: of ``one`` where a mask holds."""
    a, b, c, d, e, f, g = one
    h, i, j, k, m, n, o = other
    return (
        where(nearer, a, h), where(nearer, b, i), where(nearer, c, j), where(nearer, d, k),
        where(nearer, e, m), where(nearer, f, n), where(nearer, g, o),
    )  # fmt: skip


@inlined
def aim(q, over, length, round, found):
    """The axis that an edge from q makes the same angle with wherever its end is on a ball or on a flat face, the
    cosine of that angle and its sine; ``over``: 1 over the edge's length."""
    ox, oy, oz, r, _, _, _ = found
    ax = where(round, ox - q[0], -ox)
    ay = where(round, oy - q[1], -oy)
    az = where(round, oz - q[2], -oz)
    away = root(ax * ax + ay * ay + az * az)
    f = 1.0 / max(away, TINY)
    height = q[0] * ox + q[1] * oy + q[2] * oz - r
    cosine = where(round, 0.5 * (length * length + (away - r) * (away + r)) * f, height) * over
    cosine = min(max(cosine, -1.0), 1.0)
    return (ax * f, ay * f, az * f), cosine, root(max(1.0 - cosine * cosine, 0.0))


@inlined
def beside(d, axis):
    """What of a vector is across an axis."""
    c = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2]
    return d[0] - c * axis[0], d[1] - c * axis[1], d[2] - c * axis[2]


@inlined
def swing(turn, d, axis, cosine, sine):
    """Turn a vector toward an axis or away from it, and scale it to length 1, where ``turn``."""
    dx, dy, dz = d
    ax, ay, az = axis
    # twice, for what is left of a vector along the axis is mostly rounding, and rounding is not across it
    nx, ny, nz = beside(beside(d, axis), axis)
    square = nx * nx + ny * ny + nz * nz
    lost = square < LEAST * LEAST
    if some(lost):  # straight at it: any way round will do
        one = where(abs(ax) > 0.5, spread(ax, 0.0), 1.0)
        two = 1.0 - one
        c = one * ax + two * ay
        nx = where(lost, one - c * ax, nx)
        ny = where(lost, two - c * ay, ny)
        nz = where(lost, -c * az, nz)
        square = nx * nx + ny * ny + nz * nz
    f = sine / root(square)
    x = where(turn, cosine * ax + f * nx, dx)
    y = where(turn, cosine * ay + f * ny, dy)
    return x, y, where(turn, cosine * az + f * nz, dz)


@inner
def off_solids(q, d, next, length, over, solids, whole, first):
    """Turn an edge from q along d off every solid that its end is in; overlapping ones take turns a few times."""
    slack = SLACK * length
    for _ in range(ROUNDS):
        x = q[0] + length * d[0]
        y = q[1] + length * d[1]
        z = q[2] + length * d[2]
        depth, round, found = nearest(x, y, z, d, next, length, q, -slack, solids, whole, first)
        inside = depth > slack
        if not some(inside):
            break
        axis, cosine, sine = aim(q, over, length, round, found)
        d = swing(inside, d, axis, cosine, sine)
    return d


@inner
def touch(d, next, q, old, going, held, light, length, over, solids, whole, first, friction):
    """The unit edge d from q, turned off all solids; ``first``: whether q is the root.

    next: the edge after it; old: where the particle was before the step; going: how far its velocity alone would take
    it in this step; held: the force of contact in the step before, and light, how heavy the particle is beside all that
    this moves; over: 1 over the edge's length. Returns the edge, the force without that of impacts, and where force is
    new."""
    hx, hy, hz = held
    x = q[0] + length * d[0]
    y = q[1] + length * d[1]
    z = q[2] + length * d[2]
    grip = root(hx * hx + hy * hy + hz * hz)
    was = grip > 0.0
    reach = grip * light
    none = spread(x, 0.0)
    depth, round, found = nearest(x, y, z, d, next, length, old, reach, solids, whole, first)
    near = depth > -reach
    if not some(near | was):
        return d, (none, none, none), near
    bulk = 1.0 / light
    ox, oy, oz, r, tx, ty, tz = found
    nx, ny, nz = where(round, x - ox, ox), where(round, y - oy, oy), where(round, z - oz, oz)
    force = max(hx * nx + hy * ny + hz * nz, 0.0) / where(round, max(r - depth, TINY), 1.0) + bulk * depth
    near = near & (force > 0.0)
    new = near & ~was
    force = where(near, force, 0.0)
    free = was & ~near
    if some(free):
        f = over * light
        x = d[0] - f * hx
        y = d[1] - f * hy
        z = d[2] - f * hz
        f = 1.0 / root(max(x * x + y * y + z * z, TINY))
        d = where(free, f * x, d[0]), where(free, f * y, d[1]), where(free, f * z, d[2])
    fx = none
    fy = none
    fz = none
    if some(near):
        axis, cosine, sine = aim(q, over, length, round, found)
        d = swing(near, d, axis, cosine, sine)
        x = q[0] + length * d[0]
        y = q[1] + length * d[1]
        z = q[2] + length * d[2]
        f = 1.0 / where(round, r, 1.0)
        nx = where(round, x - ox, ox) * f
        ny = where(round, y - oy, oy) * f
        nz = where(round, z - oz, oz) * f
        f = hx * nx + hy * ny + hz * nz
        hx -= f * nx
        hy -= f * ny
        hz -= f * nz
        f = (x - tx) * nx + (y - ty) * ny + (z - tz) * nz
        fx = hx - bulk * (x - tx - f * nx)
        fy = hy - bulk * (y - ty - f * ny)
        fz = hz - bulk * (z - tz - f * nz)
        f = min(friction * force / root(max(fx * fx + fy * fy + fz * fz, TINY)), 1.0)
        fx *= f
        fy *= f
        fz *= f
        f = where(near, over * light, 0.0)
        d = swing(near, (d[0] + f * (fx - hx), d[1] + f * (fy - hy), d[2] + f * (fz - hz)), axis, cosine, sine)
        fx = where(near, fx + force * nx, 0.0)
        fy = where(near, fy + force * ny, 0.0)
        fz = where(near, fz + force * nz, 0.0)
        if some(new):
            # an impact is no force that stays: of the depth, what velocity alone has led to
            f = nx * (tx - old[0] - going[0]) + ny * (ty - old[1] - going[1]) + nz * (tz - old[2] - going[2])
            f = max(depth - max(f, 0.0), 0.0) / max(depth, TINY)
            f = where(new, f, 1.0)
            fx *= f
            fy *= f
            fz *= f
    return off_solids(q, d, next, length, over, solids, whole, first), (fx, fy, fz), new
