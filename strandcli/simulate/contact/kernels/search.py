"""Search for the solid that is nearest to a segment, and the next one: written to the scratch, row by row.

Coordinates are vectors of lanes, metres. Solids are packed as by `strandcli.solids.pack`, each row followed by its
motion in this step; all solids of a kind are a pair: pointer to the numbers of all rows, and how many numbers. Meshes
and SDF shapes come after these, by the functions of their class (`strandcli.solids.kernels.compose`), lane by
lane. Functions that take such functions are inlined: machine code with their addresses could not be cached.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

from numba.core import types

from ....constants import W
from ....jit import device, inlined
from ....jit.pruned import by_type
from ....simd import (
    any_lane,
    broadcast,
    lane,
    lane_count,
    load,
    load3,
    sqrt,
    store,
    store3,
    where,
    with_lane,
)
from ....simd.vectors import add_scaled, dot, less, scaled, select
from ....solids import COLUMNS
from ....solids.custom import REACH, X, Y, Z
from ....solids.kernels import box, capsule, plane, sphere
from ....solids.kernels.distance_field import deepest, distance, drift
from ....solids.kernels.distance_field import normal as normal_at
from ...rod.kernels.arrays import MOTION

LEAST_SHARE = 0.25
"""Of a segment, from which on its places count: those near its beginning are the segment's before it."""
NEAR_ROOT = 0.05
"""The same of the first segment."""
FAR = 1e18
"""A gap where there is no solid near, metres."""
OUT_OF_REACH = 1e20
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
    """`Custom`, or None."""
    moved: Any
    """Whether solids have moved since the particles were where they are."""
    shift: Any
    """(3) displacement of the root in the step, metres."""


class Custom(NamedTuple):
    """Meshes and SDF shapes."""

    all: Any
    """Rows and data, as `strandcli.solids.custom.together` has them."""
    last: Any
    columns: Any
    """Numbers of all rows, and of one."""


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

    ``start``, ``end``: the segment; ``past``: `Past`; ``options``: whether all of it counts and not its end alone, up
    to which distance solids count, and from which share of the segment on its places do."""
    near = False
    whole, reach, first = options
    x, y, z = end
    rows, last = contact.spheres
    for m in range(0, last, SPHERE):
        share, centre = broadcast(reach, 1.0), (rows[m + sphere.X], rows[m + sphere.Y], rows[m + sphere.Z])
        away = less(end, centre)
        if whole:
            share = nearest_share(start, end, centre, first)
            away = less(place(start, end, share), centre)
        far = reach + rows[m + sphere.RADIUS]
        if any_lane(dot(away, away) < far * far):
            at = place(start, end, share)
            near = of_ball(s, j, near, away, rows[m + sphere.RADIUS], share)
            near = with_slip(s, j, near, at, (rows, m + OF_SPHERE), past, contact.moved)
    rows, last = contact.capsules
    for m in range(0, last, CAPSULE):
        share = broadcast(reach, 1.0)
        at = end
        if whole:
            _, share = capsule.off_axis(rows, m, start, less(end, start))
            share = max(share, first)
            at = place(start, end, share)
        away = less(at, capsule.on_axis(rows, m, at[0], at[1], at[2]))
        far = reach + rows[m + capsule.RADIUS]
        if any_lane(dot(away, away) < far * far):
            near = of_ball(s, j, near, away, rows[m + capsule.RADIUS], share)
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
    return nearest_custom(s, j, near, start, end, past, contact, options)


@inlined
def place(a, b, share):
    """A place on the segment from a to b."""
    return add_scaled(a, share, less(b, a))


@device
def consider(s, j, near, gap, normal, share):
    """Take a solid into account at a place with a ``share``; mark in `Scratch.nearer` where it is the nearest. Returns
    True. ``near``: whether there has been one before."""
    one = broadcast(gap, 1.0)
    if not near:
        store(s.gap, j, gap)
        store3(s.normal, 3 * j, 1, normal[0], normal[1], normal[2])
        store(s.place, j, share)
        store(s.second_gap, j, FAR)
        store3(s.second_normal, 3 * j, 1, 0.0, 0.0, 0.0)
        store(s.nearer, j, one)
        return True
    best, second = load(s.gap, j), load(s.second_gap, j)
    nearer, next = gap < best, gap < second
    for k in range(3):
        past = load(s.normal, 3 * j + k)
        store(s.second_normal, 3 * j + k, where(nearer, past, where(next, normal[k], load(s.second_normal, 3 * j + k))))
        store(s.normal, 3 * j + k, where(nearer, normal[k], past))
    store(s.second_gap, j, min(max(gap, best), second))
    store(s.gap, j, min(gap, best))
    store(s.place, j, where(nearer, share, load(s.place, j)))
    store(s.nearer, j, where(nearer, one, 0.0))
    return True


@inlined
def with_slip(s, j, near, at, motion, past, moves):
    """Set by how much the place has moved on the solid that was considered last, where it is the nearest, if solids
    touch some lane. ``motion``: its rows, and the column where its motion begins; ``moves``: whether it has moved.
    Returns ``near``."""
    if any_lane((load(s.active, j) > 0.0) | (load(s.gap, j) < 0.0)):
        begin = less(load3(past.positions, past.place - 3 * W, W), past.shift)
        before = place(begin, load3(past.positions, past.place, W), load(s.place, j))
        if moves:
            rows, m = motion
            x, y, z = before
            before = (
                rows[m] * x + rows[m + 1] * y + rows[m + 2] * z + rows[m + 9],
                rows[m + 3] * x + rows[m + 4] * y + rows[m + 5] * z + rows[m + 10],
                rows[m + 6] * x + rows[m + 7] * y + rows[m + 8] * z + rows[m + 11],
            )
        x, y, z = select(load(s.nearer, j) > 0.0, less(at, before), load3(s.slip, 3 * j, 1))
        store3(s.slip, 3 * j, 1, x, y, z)
    return near


@inlined
def nearest_share(a, b, point, first):
    """Where on the segment from a to b a point is nearest, from a share ``first`` on."""
    e = less(b, a)
    return min(max(dot(less(point, a), e) / max(dot(e, e), TINY), first), 1.0)


@inlined
def of_ball(s, j, near, away, radius, share):
    """`consider` a ball, from whose centre the place is ``away``."""
    size = sqrt(dot(away, away))
    x, y, z = scaled(1.0 / max(size, TINY), away)
    return consider(s, j, near, size - radius, (x, where(size < TINY, 1.0, y), z), share)


@functools.partial(by_type, inline=True)
def nearest_custom(s, j, near, start, end, past, contact, options):
    """As `nearest`, among custom solids, after those of which some have been ``near``."""
    kind = dict(zip(contact.fields, contact.types, strict=True))["custom"]
    if isinstance(kind, types.NoneType):
        return lambda s, j, near, start, end, past, contact, options: near
    drifts = None if kind[0].instance_class.drift is None else True
    return lambda s, j, near, start, end, past, contact, options: among(
        s, j, near, start, end, past, contact, options, drifts
    )


@inlined
def among(s, j, near, start, end, past, contact, options, drifts):
    """Search among custom solids. ``drifts``: None where none of their surfaces moves, else what these carry along
    slides by less."""
    shapes = contact.custom.all
    for m in range(0, contact.custom.last, contact.custom.columns):
        if in_reach(shapes, m, end, options[1]):
            gap, normal, share = gap_of(shapes, m, start, end, options)
            if any_lane(gap < options[1]):
                near = consider(s, j, near, gap, normal, share)
                at, motion = place(start, end, share), (shapes.rows, m + contact.custom.columns - MOTION)
                near = with_slip(s, j, near, at, motion, past, contact.moved)
                if drifts is not None and contact.moved:
                    carry(s, j, at, shapes, m, gap < options[1])
    return near


@inlined
def gap_of(shapes, m, start, end, options):
    """Gap and normal of a segment, metres, and where on it; of lanes out of reach the gap is `OUT_OF_REACH`."""
    whole, reach, first = options
    x, y, z = end
    gap, share = broadcast(x, OUT_OF_REACH), broadcast(x, 1.0)
    nx, ny, nz = broadcast(x, 0.0), broadcast(x, 1.0), broadcast(x, 0.0)
    for k in range(lane_count(shapes.rows)):
        a, b, c = lane(x, k), lane(y, k), lane(z, k)
        d = distance(shapes, m, a, b, c)
        if whole and d < 2.0 * lane(reach, k):
            p, q, r = lane(start[0], k), lane(start[1], k), lane(start[2], k)
            at, under = deepest(shapes, m, (p, q, r), (a - p, b - q, c - r))
            if -under < d and at >= lane(first, k):
                d = -1.0 * under
                share = with_lane(share, k, 1.0 * at)
                a, b, c = p + at * (a - p), q + at * (b - q), r + at * (c - r)
        if d < lane(reach, k):
            u, v, w = normal_at(shapes, m, a, b, c)
            gap = with_lane(gap, k, 1.0 * d)
            nx, ny, nz = with_lane(nx, k, u), with_lane(ny, k, v), with_lane(nz, k, w)
    return gap, (nx, ny, nz), share


@device
def in_reach(shapes, m, end, far):
    """Whether the end of the segment is within `far` of a solid's bounding ball in any lane."""
    rows = shapes.rows
    away = less(end, (rows[m + X], rows[m + Y], rows[m + Z]))
    far += rows[m + REACH]
    return any_lane(dot(away, away) < far * far)


@inlined
def carry(s, j, at, shapes, m, lanes):
    """Take from the slip what the surface of the solid considered last drifts by, where that is the nearest."""
    mine = lanes & (load(s.nearer, j) > 0.0)
    asked = where(mine, broadcast(at[0], 1.0), 0.0)
    u, v, w = load3(s.slip, 3 * j, 1)
    for k in range(lane_count(shapes.rows)):
        if lane(asked, k) > 0.0:
            x, y, z = drift(shapes, m, lane(at[0], k), lane(at[1], k), lane(at[2], k))
            u = with_lane(u, k, lane(u, k) - x)
            v = with_lane(v, k, lane(v, k) - y)
            w = with_lane(w, k, lane(w, k) - z)
    store3(s.slip, 3 * j, 1, u, v, w)
