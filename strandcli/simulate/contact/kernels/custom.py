"""Search among solids without kernels of their own, meshes and SDF shapes: as `search`, by the functions that
`strandcli.solids.shapes.other_code` writes.

A `Contact` has them as ``custom``, or None. The class of that holds the functions distance, normal, deepest, and drift
where a kind has it. Lanes are computed one after the other, in scalars. Functions that take such functions are inlined:
machine code with their addresses could not be cached.
"""

from __future__ import annotations

from numba.core import types
from numba.extending import overload

from ....jit import device, inlined
from ....simd import any_lane, broadcast, lane, lane_count, load, load3, store3, where, with_lane
from ....solids.shapes.other import REACH, X, Y, Z
from ...rod.kernels.arrays import MOTION
from .candidates import consider, place, with_slip

FAR = 1e20


def nearest(s, j, near, start, end, past, contact, options):
    """As `search.nearest`, among such solids after others, of which some have been ``near``."""


@overload(nearest)
def _nearest(s, j, near, start, end, past, contact, options):
    kind = dict(zip(contact.fields, contact.types, strict=True))["custom"]
    if isinstance(kind, types.NoneType):
        return lambda s, j, near, start, end, past, contact, options: near
    form = kind.instance_class
    distance, normal, deepest, drift = form.distance, form.normal, form.deepest, form.drift

    if drift is None:
        return lambda s, j, near, start, end, past, contact, options: among(
            s, j, near, start, end, past, contact, options, (contact.custom.all, distance, normal, deepest)
        )
    return lambda s, j, near, start, end, past, contact, options: among_moving(
        s, j, near, start, end, past, contact, options, (contact.custom.all, distance, normal, deepest), drift
    )


@inlined
def among(s, j, near, start, end, past, contact, options, shape):
    """Search among solids whose surfaces do not drift."""
    for m in range(0, contact.custom.last, contact.custom.columns):
        if in_reach(shape[0], m, end, options[1]):
            gap, normal, share = gap_of(shape, m, start, end, options)
            if any_lane(gap < options[1]):
                near = consider(s, j, near, gap, normal, share)
                at, motion = place(start, end, share), (shape[0].rows, m + contact.custom.columns - MOTION)
                near = with_slip(s, j, near, at, motion, past, contact.moved)
    return near


@inlined
def among_moving(s, j, near, start, end, past, contact, options, shape, drift):
    """Search among solids of which some surfaces drift: what these carry along slides by less."""
    for m in range(0, contact.custom.last, contact.custom.columns):
        if in_reach(shape[0], m, end, options[1]):
            gap, normal, share = gap_of(shape, m, start, end, options)
            if any_lane(gap < options[1]):
                near = consider(s, j, near, gap, normal, share)
                at, motion = place(start, end, share), (shape[0].rows, m + contact.custom.columns - MOTION)
                near = with_slip(s, j, near, at, motion, past, contact.moved)
                if contact.moved:
                    carry(s, j, at, shape[0], m, gap < options[1], drift)
    return near


@inlined
def gap_of(shape, m, start, end, options):
    """Gap and normal of a segment, metres, and where on it; of lanes out of reach the gap is `FAR`."""
    others, distance, normal, deepest = shape
    whole, reach, first = options
    x, y, z = end
    gap, share = broadcast(x, FAR), broadcast(x, 1.0)
    nx, ny, nz = broadcast(x, 0.0), broadcast(x, 1.0), broadcast(x, 0.0)
    for k in range(lane_count(others.rows)):
        a, b, c = lane(x, k), lane(y, k), lane(z, k)
        d = distance(others, m, a, b, c)
        if whole and d < 2.0 * lane(reach, k):
            p, q, r = lane(start[0], k), lane(start[1], k), lane(start[2], k)
            at, under = deepest(others, m, (p, q, r), (a - p, b - q, c - r))
            if -under < d and at >= lane(first, k):
                d = -1.0 * under
                share = with_lane(share, k, 1.0 * at)
                a, b, c = p + at * (a - p), q + at * (b - q), r + at * (c - r)
        if d < lane(reach, k):
            u, v, w = normal(others, m, a, b, c)
            gap = with_lane(gap, k, 1.0 * d)
            nx = with_lane(nx, k, u)
            ny = with_lane(ny, k, v)
            nz = with_lane(nz, k, w)
    return gap, (nx, ny, nz), share


@device
def in_reach(others, m, end, far):
    """Whether the end of the segment is within `far` of a solid's bounding ball in any lane."""
    rows = others.rows
    dx, dy, dz = end[0] - rows[m + X], end[1] - rows[m + Y], end[2] - rows[m + Z]
    far += rows[m + REACH]
    return any_lane(dx * dx + dy * dy + dz * dz < far * far)


@inlined
def carry(s, j, at, others, m, lanes, drift):
    """Take from the slip what the surface of the solid considered last drifts by, where that is the nearest."""
    mine = lanes & (load(s.nearer, j) > 0.0)
    asked = where(mine, broadcast(at[0], 1.0), 0.0)
    u, v, w = load3(s.slip, 3 * j, 1)
    for k in range(lane_count(others.rows)):
        if lane(asked, k) > 0.0:
            x, y, z = drift(others, m, lane(at[0], k), lane(at[1], k), lane(at[2], k))
            u = with_lane(u, k, lane(u, k) - x)
            v = with_lane(v, k, lane(v, k) - y)
            w = with_lane(w, k, lane(w, k) - z)
    store3(s.slip, 3 * j, 1, u, v, w)
