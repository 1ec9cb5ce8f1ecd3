"""Search for the solid that is nearest to a segment, and the next one: written to the scratch, row by row.

Coordinates are vectors of lanes, metres. Solids are packed as by `strandcli.solids.pack`, each row followed by its
motion in this step; all solids of a kind are a pair: pointer to the numbers of all rows, and how many numbers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ....jit import inlined
from ....simd import any_lane, broadcast, sqrt, where
from ....solids import COLUMNS
from ....solids.kernels import box, capsule, plane, sphere
from ...rod.kernels.arrays import MOTION
from ...rod.kernels.vectors import dot
from . import custom
from .candidates import consider, place, with_slip

LEAST_SHARE = 0.25
"""Of a segment, from which on its places count: those near its beginning are left to the segment before it, and a held
root gives way to no force."""
NEAR_ROOT = 0.05
"""The same of the first segment."""
TINY = 1e-20
OF_SPHERE, OF_CAPSULE, OF_PLANE, OF_BOX = COLUMNS.values()
SPHERE, CAPSULE, PLANE, BOX = (columns + MOTION for columns in COLUMNS.values())


class Contact(NamedTuple):
    """Solids at the end of a step."""

    spheres: Any
    capsules: Any
    planes: Any
    boxes: Any
    custom: Any
    """Meshes and SDF shapes, as `custom` takes them, or None."""
    moved: Any
    """Whether solids have moved since the particles were where they are."""
    shift: Any
    """(3) displacement of the root in the step, metres."""


class Past(NamedTuple):
    """Where a segment was before the step."""

    positions: Any
    place: Any
    """Of its end in the positions."""
    shift: Any
    """(3) by how much its beginning has moved in the positions since then: the root's."""


@inlined
def nearest(s, j, start, end, past, contact, options):
    """Set the gap, the normal, the place and the slip of segment j on the solid that is nearest to it, metres, and gap
    and normal of the next one; return whether some solid is within reach of some lane, else nothing is set.

    ``start``, ``end``: the segment; ``past``: `Past`; ``options``: whether all of it is kept out and not its end alone,
    up to which
    distance solids count, and from which share of the segment on its places do."""
    near = False
    whole, reach, first = options
    x, y, z = end
    rows, last = contact.spheres
    for m in range(0, last, SPHERE):
        share = broadcast(reach, 1.0)
        dx, dy, dz = x - rows[m + sphere.X], y - rows[m + sphere.Y], z - rows[m + sphere.Z]
        if whole:
            share = nearest_share(start, end, (rows[m + sphere.X], rows[m + sphere.Y], rows[m + sphere.Z]), first)
            u, v, w = place(start, end, share)
            dx, dy, dz = u - rows[m + sphere.X], v - rows[m + sphere.Y], w - rows[m + sphere.Z]
        far = reach + rows[m + sphere.RADIUS]
        if any_lane(dx * dx + dy * dy + dz * dz < far * far):
            at = place(start, end, share)
            near = of_ball(s, j, near, at, (dx, dy, dz), rows[m + sphere.RADIUS], (rows, m + OF_SPHERE), share)
            near = with_slip(s, j, near, at, (rows, m + OF_SPHERE), past, contact.moved)
    rows, last = contact.capsules
    for m in range(0, last, CAPSULE):
        share = broadcast(reach, 1.0)
        at = end
        if whole:
            share = beside_capsule(start, end, rows, m, first)
            at = place(start, end, share)
        u, v, w = capsule.on_axis(rows, m, at[0], at[1], at[2])
        dx, dy, dz = at[0] - u, at[1] - v, at[2] - w
        far = reach + rows[m + capsule.RADIUS]
        if any_lane(dx * dx + dy * dy + dz * dz < far * far):
            near = of_ball(s, j, near, at, (dx, dy, dz), rows[m + capsule.RADIUS], (rows, m + OF_CAPSULE), share)
            near = with_slip(s, j, near, at, (rows, m + OF_CAPSULE), past, contact.moved)
    rows, last = contact.planes
    for m in range(0, last, PLANE):
        gap = -plane.depth(rows, m, x, y, z)
        if any_lane(gap < reach):
            one = broadcast(gap, 1.0)
            normal = rows[m + plane.X] * one, rows[m + plane.Y] * one, rows[m + plane.Z] * one
            near = consider(s, j, near, gap, normal, one)
            near = with_slip(s, j, near, end, (rows, m + OF_PLANE), past, contact.moved)
    rows, last = contact.boxes
    for m in range(0, last, BOX):
        depth, nx, ny, nz = box.depth(rows, m, x, y, z)
        share = broadcast(depth, 1.0)
        if whole:
            depth, (nx, ny, nz), share = box.touch(rows, m, start, end, first)
        if any_lane(depth > -reach):
            near = consider(s, j, near, -depth, (nx, ny, nz), share)
            near = with_slip(s, j, near, place(start, end, share), (rows, m + OF_BOX), past, contact.moved)
    return custom.nearest(s, j, near, start, end, past, contact, options)


@inlined
def nearest_share(a, b, point, first):
    """Where on the segment from a to b a point is nearest, from a share ``first`` on."""
    e = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    away = point[0] - a[0], point[1] - a[1], point[2] - a[2]
    return min(max(dot(away, e) / max(dot(e, e), TINY), first), 1.0)


@inlined
def beside_capsule(a, b, rows, m, first):
    """Where on the segment it is nearest to a capsule's axis, by alternating projections."""
    x, y, z = b
    share = broadcast(x, 1.0)
    for _ in range(3):
        share = nearest_share(a, b, capsule.on_axis(rows, m, x, y, z), first)
        x, y, z = place(a, b, share)
    return share


@inlined
def of_ball(s, j, near, at, away, radius, motion, share):
    """`consider` a ball, from whose centre the place is ``away``."""
    x, y, z = away
    size = sqrt(x * x + y * y + z * z)
    over = 1.0 / max(size, TINY)
    return consider(s, j, near, size - radius, (over * x, where(size < TINY, 1.0, over * y), over * z), share)
