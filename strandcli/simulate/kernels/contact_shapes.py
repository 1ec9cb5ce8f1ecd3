"""Where solids are from a particle of a rod: how deep it is, and the ball or the flat face that is to keep it out.

Solids come packed as by `strandcli.solids.pack`, each row followed by 12 numbers: the rigid motion (rotation by rows,
translation) that took it through this step. Solids of a kind are handed on as rows and how many numbers these hold, one
of them as rows and its place; all of them in the order spheres, capsules, planes, boxes. Coordinates are vectors of
lanes; a solid that is out of every lane's reach costs no more than finding that out.

Where whole edges are caught, each particle stays far enough from a solid that the near halves of its edges do, as they
lie: √(r² + s²) from a ball, where s is how far along a half it is nearest. So no edge is a lever that a touch near its
beginning would throw up. Of the first edge, whose root cannot give way, the particle takes care of all.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, load3, sqrt, where
from ...solids import COLUMNS
from ...solids.kernels import box, capsule, plane, sphere
from ...solids.kernels.box import HALF, ROW_X, ROW_Y, ROW_Z
from .contact_others import MOTION, by_others
from .contact_place import find
from .rod import FOUND, SEGMENT, E

TINY = 1e-20
LEAST = 1e-6
OF_SPHERE, OF_CAPSULE, OF_PLANE, OF_BOX = COLUMNS.values()
SPHERE, CAPSULE, PLANE, BOX = (columns + MOTION for columns in COLUMNS.values())
"""Columns of a packed solid without its motion, and with it."""


@device
def cut(boxes, m, x, y, z, dx, dy, dz, reach):
    """How deep a line from (x, y, z) on is in a box within ``reach``, and the direction in which that is. One that
    enters by a face F and leaves by a face G cuts off an edge of the box; the way out is across both the line and that
    edge, |d·G| F + |d·F| G. One that has passed G before it comes to F goes by the edge, at a negative depth. One that
    leaves by the opposite face, or not at all, is led out by the nearest face. -1 / TINY: neither of them."""
    zero = broadcast(x, 0.0)
    enter = zero
    leave = reach
    f = zero
    g = zero
    ax, ay, az = zero, zero, zero
    bx, by, bz = zero, zero, zero
    for k in range(3):
        half = boxes[m + HALF + k]
        q = box.own(boxes, m, k, x - boxes[m + box.X], y - boxes[m + box.Y], z - boxes[m + box.Z])
        d = box.own(boxes, m, k, dx, dy, dz)
        size = max(abs(d), TINY)
        way = where(d < 0.0, broadcast(x, -1.0), 1.0)
        begin = -(half + way * q) / size
        end = (half - way * q) / size
        later = begin > enter
        enter = max(enter, begin)
        f = where(later, size, f)
        ax = where(later, -way * boxes[m + ROW_X + k], ax)
        ay = where(later, -way * boxes[m + ROW_Y + k], ay)
        az = where(later, -way * boxes[m + ROW_Z + k], az)
        sooner = end < leave
        leave = min(leave, end)
        g = where(sooner, size, g)
        bx = where(sooner, way * boxes[m + ROW_X + k], bx)
        by = where(sooner, way * boxes[m + ROW_Y + k], by)
        bz = where(sooner, way * boxes[m + ROW_Z + k], bz)
    inside = leave > enter
    if not any_lane(inside | ((f > 0.0) & (g > 0.0))):
        return broadcast(x, -1.0 / TINY), zero, zero, zero
    nx = g * ax + f * bx
    ny = g * ay + f * by
    nz = g * az + f * bz
    size = sqrt(nx * nx + ny * ny + nz * nz)
    edge = size > LEAST
    over = 1.0 / max(size, LEAST)
    depth = (leave - enter) * f * g * over
    nx *= over
    ny *= over
    nz *= over
    if any_lane(inside & ~edge):
        t = where(g > 0.0, 0.5 * (enter + leave), leave)
        d, ax, ay, az = box.depth(boxes, m, x + t * dx, y + t * dy, z + t * dz)
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
        return broadcast(dx, r)
    back, on = foot(dx, dy, dz, edge, next, 0.5 * length)
    if first:
        x = dx - length * edge[0]
        y = dy - length * edge[1]
        z = dz - length * edge[2]
        back = max(length - sqrt(max(x * x + y * y + z * z - r * r, 0.0)), 0.0)
    s = max(back, on)
    return sqrt(s * s + r * r)


@device
def toward_axis(capsules, m, point, on_axis, edges, lever):
    """Point of a capsule's axis that is nearest to a particle's edges up to ``lever`` away from it, begun with the one
    that is nearest to the particle: by alternating projections."""
    x, y, z = point
    ox, oy, oz = on_axis
    edge, next = edges
    for _ in range(2):
        back, on = foot(x - ox, y - oy, z - oz, edge, next, lever)
        behind = back > on
        back = where(behind, back, 0.0)
        on = where(behind, 0.0, on)
        ox, oy, oz = capsule.on_axis(
            capsules, m, x - back * edge[0] + on * next[0], y - back * edge[1] + on * next[1],
            z - back * edge[2] + on * next[2],
        )  # fmt: skip
    return ox, oy, oz


@device
def deeper(one, other):
    """Of two ways out of a box, (depth, normal) each, the longer one."""
    a = one[0] > other[0]
    return (
        max(one[0], other[0]), where(a, one[1], other[1]), where(a, one[2], other[2]), where(a, one[3], other[3]),
    )  # fmt: skip


@device
def past_edge(boxes, m, point, under, edges, lever, length, far):
    """`box.depth`, which found a particle ``under`` it, or where it is outside how deep the near parts of its edges
    are, if no further away than ``far``."""
    x, y, z = point
    edge, next = edges
    out = under[0] <= 0.0
    back = cut(boxes, m, x, y, z, -edge[0], -edge[1], -edge[2], lever)
    depth, nx, ny, nz = deeper(back, cut(boxes, m, x, y, z, next[0], next[1], next[2], 0.5 * length))
    return deeper((where(out & (depth > -far), depth, -1.0 / TINY), nx, ny, nz), under)


@inlined
def nearest(s, o, point, edge, length, at, reach, solids, whole, first):
    """How deep the particle of segment o is in the solid that it is deepest in, or nearest to and no further than
    ``reach``, and from where on the scratch tells of that solid; a depth of -reach: there is none.

    point: where the particle is; edge: its unit edge, the next one being in the segment after o; at: positions and the
    place in them where the particle was before this step; solids: pairs of rows and where they end, spheres, capsules,
    planes, boxes, and perhaps others (`contact_others`); whole: edges are kept out too, of the first one all. Scratch
    holds the centre and radius, or of a flat face the normal and how far along that the particle has to be; where the
    solid has carried the particle's place in this step; 1 where it is round there and 0 where flat.
    """
    x, y, z = point
    spheres, last_sphere = solids[0]
    capsules, last_capsule = solids[1]
    planes, last_plane = solids[2]
    boxes, last_box = solids[3]
    most = -reach
    found, other = FOUND, FOUND + 8
    next = (most, most, most)
    lever = broadcast(x, 0.0)  # how far the nearest place of an edge may be from the particle
    if whole:
        next = load3(s, o + SEGMENT + E, 1)
        lever = length if first else 0.5 * length
    for m in range(0, last_sphere, SPHERE):
        dx, dy, dz = x - spheres[m], y - spheres[m + 1], z - spheres[m + 2]
        far = spheres[m + sphere.RADIUS] + lever - most
        if any_lane(dx * dx + dy * dy + dz * dz < far * abs(far)):
            r = kept_from(dx, dy, dz, spheres[m + sphere.RADIUS], edge, next, length, whole, first)
            d = sphere.under(dx, dy, dz, r)
            place = broadcast(x, spheres[m]), broadcast(x, spheres[m + 1]), broadcast(x, spheres[m + 2])
            found, other = find(s, found, other, d > most, 1.0, place, r, spheres, m + OF_SPHERE, at)
            most = max(most, d)
    for m in range(0, last_capsule, CAPSULE):
        ox, oy, oz = capsule.on_axis(capsules, m, x, y, z)
        dx, dy, dz = x - ox, y - oy, z - oz
        far = capsules[m + capsule.RADIUS] + lever - most
        if any_lane(dx * dx + dy * dy + dz * dz < far * abs(far)):
            if whole:
                ox, oy, oz = toward_axis(capsules, m, point, (ox, oy, oz), (edge, next), lever)
            r = kept_from(x - ox, y - oy, z - oz, capsules[m + capsule.RADIUS], edge, next, length, whole, first)
            d = sphere.under(x - ox, y - oy, z - oz, r)
            place = ox, oy, oz
            found, other = find(s, found, other, d > most, 1.0, place, r, capsules, m + OF_CAPSULE, at)
            most = max(most, d)
    for m in range(0, last_plane, PLANE):
        d = plane.depth(planes, m, x, y, z)
        if any_lane(d > most):
            way = broadcast(x, planes[m]), broadcast(x, planes[m + 1]), broadcast(x, planes[m + 2])
            level = broadcast(x, planes[m + plane.HEIGHT])
            found, other = find(s, found, other, d > most, 0.0, way, level, planes, m + OF_PLANE, at)
            most = max(most, d)
    for m in range(0, last_box, BOX):
        d, ox, oy, oz = box.depth(boxes, m, x, y, z)
        if any_lane(d + lever > most):
            if whole:
                d, ox, oy, oz = past_edge(boxes, m, point, (d, ox, oy, oz), (edge, next), lever, length, reach)
            level = d + x * ox + y * oy + z * oz
            found, other = find(s, found, other, d > most, 0.0, (ox, oy, oz), level, boxes, m + OF_BOX, at)
            most = max(most, d)
    return by_others(s, (found, other), most, (x, y, z), (edge, next), lever, at, solids)
