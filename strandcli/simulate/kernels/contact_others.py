"""Where solids of other packages are from a particle of a rod: as `contact_shapes`, by their signed distance.

Each lane by itself, in scalars. Such a solid is met as a flat face: the one that touches its surface where the
particle's way out ends, which turns as the particle moves.
"""

from __future__ import annotations

from numba.extending import overload

from ...jit import device
from ...simd import any_lane, broadcast, lane, lane_count, where, with_lane
from ...solids.kernels.distance_field import FINE, gradient
from ...solids.shapes.other import REACH, X, Y, Z
from .contact_place import find

TINY = 1e-20
MOTION = 12
"""Columns that follow a packed solid's: its motion in this step."""
ALONG = 4
"""Parts of an edge's half at which it is looked at where edges are caught."""


@device
def depth(others, distance, m, x, y, z):
    """Depth of points in the solid at place m, and its normal there."""
    under = broadcast(x, -1.0 / TINY)
    nx = broadcast(x, 0.0)
    ny = broadcast(x, 1.0)
    nz = nx
    h = FINE * others[m + REACH]
    for k in range(lane_count(others)):
        a, b, c = lane(x, k), lane(y, k), lane(z, k)
        under = with_lane(under, k, -1.0 * distance(others, m, a, b, c))
        u, v, w = gradient(distance, others, m, h, a, b, c)
        nx = with_lane(nx, k, u)
        ny = with_lane(ny, k, v)
        nz = with_lane(nz, k, w)
    return under, nx, ny, nz


@device
def in_reach(others, m, x, y, z, far):
    """Whether any lane is within `far` of the ball about a solid."""
    dx, dy, dz = x - others[m + X], y - others[m + Y], z - others[m + Z]
    far += others[m + REACH]
    return any_lane(dx * dx + dy * dy + dz * dz < far * abs(far))


@device
def deepest(others, distance, m, point, edges, lever):
    """`depth` of a particle, or of the point that is deepest of its two edges up to ``lever`` away from it."""
    x, y, z = point
    edge, next = edges
    under, nx, ny, nz = depth(others, distance, m, x, y, z)
    if not any_lane(lever > 0.0):
        return under, nx, ny, nz
    for j in range(1, ALONG + 1):
        for side in range(2):
            share = (j / ALONG) * lever * (1.0 if side == 1 else -1.0)
            after = side == 1
            ex, ey, ez = next[0] if after else edge[0], next[1] if after else edge[1], next[2] if after else edge[2]
            d, ax, ay, az = depth(others, distance, m, x + share * ex, y + share * ey, z + share * ez)
            better = (d > under) & (d > 0.0)
            under = where(better, d, under)
            nx = where(better, ax, nx)
            ny = where(better, ay, ny)
            nz = where(better, az, nz)
    return under, nx, ny, nz


@device
def nearest(s, places, most, point, edges, lever, at, others, distance):
    """What `contact_shapes.nearest` goes on with: the greatest depth and the place of that solid, others included."""
    found, other = places
    rows, last, columns = others
    x, y, z = point
    for m in range(0, last, columns):
        if in_reach(rows, m, x, y, z, lever - most):
            d, ox, oy, oz = deepest(rows, distance, m, point, edges, lever)
            level = d + x * ox + y * oy + z * oz
            found, other = find(s, found, other, d > most, 0.0, (ox, oy, oz), level, rows, m + columns - MOTION, at)
            most = max(most, d)
    return most, found


def by_others(s, places, most, point, edges, lever, at, solids):
    """`nearest` where `solids` has a fifth part and a distance; else what there was."""


@overload(by_others)
def _by_others(s, places, most, point, edges, lever, at, solids):
    if len(solids) == 4:
        return lambda s, places, most, point, edges, lever, at, solids: (most, places[0])
    return lambda s, places, most, point, edges, lever, at, solids: nearest(
        s, places, most, point, edges, lever, at, solids[4], solids[5]
    )
