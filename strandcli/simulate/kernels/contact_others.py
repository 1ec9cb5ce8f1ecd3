"""Contact of a rod's particles with solids without kernels of their own: as `contact_shapes`, by the functions that
`strandcli.solids.shapes.other_code` writes.

`shape` is the `Others` of all solids, and the functions distance, normal and deepest of a solid whose row begins at an
index of the rows; and drift, where a kind of them has it. `Others` comes first, because Numba types a tuple of
functions alone differently. The functions come with a type, and functions that take them are inlined: machine code with
their addresses could not be cached.

Lanes are computed one after the other, in scalars. The contact is with a face: the tangent plane at the end of the
particle's way out, which turns as the particle moves.
"""

from __future__ import annotations

from numba.extending import overload

from ...jit import device, inlined
from ...simd import any_lane, broadcast, lane, lane_count, load3, store3, where, with_lane
from ...solids.shapes.other import REACH, X, Y, Z
from .contact_place import CARRIED, is_nearer, write_slot
from .records import MOTION, OTHERS

TINY = 1e-20


@inlined
def depth(shape, m, x, y, z, most):
    """Return the depth of points in the solid whose row begins at m and, in lanes that are deeper than ``most``, its
    normal there: what others have is not read, and takes longer to find than the depth."""
    others, distance, normal = shape[:3]
    under = broadcast(x, -1.0 / TINY)
    nx = broadcast(x, 0.0)
    ny = broadcast(x, 1.0)
    nz = nx
    for k in range(lane_count(others.rows)):
        under = with_lane(under, k, -1.0 * distance(others, m, lane(x, k), lane(y, k), lane(z, k)))
    if any_lane(under > most):
        for k in range(lane_count(others.rows)):
            if lane(under, k) > lane(most, k):
                u, v, w = normal(others, m, lane(x, k), lane(y, k), lane(z, k))
                nx = with_lane(nx, k, u)
                ny = with_lane(ny, k, v)
                nz = with_lane(nz, k, w)
    return under, nx, ny, nz


@device
def in_reach(others, m, x, y, z, far):
    """Return whether any lane is within `far` of a solid's bounding ball."""
    rows = others.rows
    dx, dy, dz = x - rows[m + X], y - rows[m + Y], z - rows[m + Z]
    far += rows[m + REACH]
    return any_lane(dx * dx + dy * dy + dz * dz < far * abs(far))


@inlined
def deepest(shape, m, point, edges, lever, most):
    """Return `depth` of a particle, or of the deepest point of its two edges within ``lever`` of it."""
    x, y, z = point
    edge, next = edges
    under, nx, ny, nz = depth(shape, m, x, y, z, most)
    if not any_lane(lever > 0.0):
        return under, nx, ny, nz
    others, normal, place = shape[0], shape[2], shape[3]
    for k in range(lane_count(others.rows)):
        begin = lane(x, k), lane(y, k), lane(z, k)
        least = max(lane(under, k), 0.0)
        for side in range(2):
            way = next if side == 1 else edge
            far = lane(lever, k) * (1.0 if side == 1 else -1.0)
            ex, ey, ez = far * lane(way[0], k), far * lane(way[1], k), far * lane(way[2], k)
            share, d = place(others, m, begin, (ex, ey, ez))
            if d > least:
                least = d
                u, v, w = normal(others, m, begin[0] + share * ex, begin[1] + share * ey, begin[2] + share * ez)
                under = with_lane(under, k, d)
                nx = with_lane(nx, k, u)
                ny = with_lane(ny, k, v)
                nz = with_lane(nz, k, w)
    return under, nx, ny, nz


@inlined
def nearest(s, known, places, most, point, edges, lever, at, others, shape):
    """Return the greatest depth and the slot of that solid, others included; see `contact_shapes.nearest`."""
    found, other = places
    all_of, last, columns = others
    x, y, z = point
    for m in range(0, last, columns):
        if in_reach(all_of, m, x, y, z, lever - most):
            d, ox, oy, oz = deepest(shape, m, point, edges, lever, most)
            if any_lane(d > most):
                level = d + x * ox + y * oy + z * oz
                nearer = is_nearer(s, known, d, most, (ox, oy, oz), level)
                found, other = write_slot(
                    s, found, other, nearer, 0.0, (ox, oy, oz), level, all_of.rows, m + columns - MOTION, at
                )
                carry(s, found, point, m, nearer, at, shape)
                most = where(nearer, d, most)
    return most, found


@inlined
def drift_along(s, found, point, m, nearer, shape):
    """Move where a particle would be, had the solid carried it, by the drift of the solid's surface, in lanes where
    ``nearer`` is set."""
    others, drift = shape[0], shape[4]
    x, y, z = point
    if not any_lane(nearer):
        return
    cx, cy, cz = load3(s, found + CARRIED, 1)
    asked = where(nearer, broadcast(x, 1.0), 0.0)
    for k in range(lane_count(others.rows)):
        if lane(asked, k) > 0.0:
            u, v, w = drift(others, m, lane(x, k), lane(y, k), lane(z, k))
            cx = with_lane(cx, k, lane(cx, k) + u)
            cy = with_lane(cy, k, lane(cy, k) + v)
            cz = with_lane(cz, k, lane(cz, k) + w)
    store3(s, found + CARRIED, 1, cx, cy, cz)


def carry(s, found, point, m, nearer, at, shape):
    """`drift_along` for shapes that have a drift, where ``at`` asks for it; else nothing."""


@overload(carry)
def _carry(s, found, point, m, nearer, at, shape):
    if len(shape) < 5 or len(at) < 3:
        return lambda s, found, point, m, nearer, at, shape: None
    return lambda s, found, point, m, nearer, at, shape: drift_along(s, found, point, m, nearer, shape)


def by_others(s, known, places, most, point, edges, lever, at, solids):
    """Return `nearest` if `solids` has a fifth member, whose class has the functions of its shapes; else the
    arguments."""


@overload(by_others)
def _by_others(s, known, places, most, point, edges, lever, at, solids):
    if len(solids) == OTHERS:
        return lambda s, known, places, most, point, edges, lever, at, solids: (most, places[0])
    form = solids[OTHERS].instance_class
    distance, normal, place, drift = form.distance, form.normal, form.deepest, form.drift
    if drift is not None:
        return lambda s, known, places, most, point, edges, lever, at, solids: nearest(
            s, known, places, most, point, edges, lever, at, solids[OTHERS],
            (solids[OTHERS].all, distance, normal, place, drift),
        )  # fmt: skip
    return lambda s, known, places, most, point, edges, lever, at, solids: nearest(
        s, known, places, most, point, edges, lever, at, solids[OTHERS],
        (solids[OTHERS].all, distance, normal, place),
    )  # fmt: skip


def count_of(solids):
    """Return how many solids without kernels of their own there are."""


@overload(count_of)
def _count_of(solids):
    if len(solids) == OTHERS:
        return lambda solids: 0
    return lambda solids: solids[OTHERS].last // solids[OTHERS].columns
