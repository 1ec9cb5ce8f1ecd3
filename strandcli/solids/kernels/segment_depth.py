"""Contact of segments with custom solids: the deepest point, and rotation out of a solid. p and m as in
`distance_field`; a segment is its first end and the vector to the other one."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import device, inlined
from ...simd import any_lane, sqrt, where
from ..custom import REACH, X, Y, Z
from .distance_field import (
    INF,
    ROUNDS,
    TINY,
    ZERO,
    deepest,
    distance,
    distances_in_own,
    in_world,
    normal,
    own,
    slopes_in_own,
)  # fmt: skip

PARTS = 4
"""Equal parts of a segment whose ends are tested."""
SEARCH = 20
"""Steps of golden-section search along a segment, which narrow it to 7e-5 of its length."""
HALF_PART = 0.5 / PARTS
CLOSE_SEARCH = 6
"""Steps of a search between two of those places, which narrow it to 2 % of the segment's length."""
CLOSER = (math.sqrt(5.0) - 1.0) / 2.0
MARGIN = np.float32(1.00001)
"""Factor of a radius, for more than the rounding of a distance that is compared with it."""
LEVER = np.float32(0.1)
"""Least share of a segment by which a depth is divided, as `simulate.contact.kernels.segments.LEAST_SHARE`."""


@inlined
def clears(p, m, begin, edge):
    """Return whether a segment is certainly outside of solid m: the surface is farther from its middle than its end."""
    far = distance(p, m, begin[0] + 0.5 * edge[0], begin[1] + 0.5 * edge[1], begin[2] + 0.5 * edge[2])
    return far > 0 and 4.0 * far * far >= edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2]


@inlined
def along(p, m, begin, edge, t):
    """Return the signed distance of the point at share t of a segment from the surface of solid m."""
    return distance(p, m, begin[0] + t * edge[0], begin[1] + t * edge[1], begin[2] + t * edge[2])


def deepest_of_some(p, m, begin, edge):
    """Return the share of a segment at which it is deepest in solid m, of `PARTS` points including its end, and the
    depth there, metres; not positive if none is inside."""
    share, most = 1.0, -1.0 * INF
    if not clears(p, m, begin, edge):
        for j in range(1, PARTS + 1):
            t = j / PARTS
            under = -1.0 * along(p, m, begin, edge, t)
            if under > most:
                share, most = t, under
    return share, most


deepest_part = device(deepest_of_some)


def deepest_about_some(p, m, begin, edge):
    """The same, and of all places around the deepest of those: by golden-section search between its neighbours."""
    share, most = deepest_part(p, m, begin, edge)
    if most <= -HALF_PART * math.sqrt(edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2]):
        return share, most  # between two places the depth grows by no more than that
    low, high = max(share - 1.0 / PARTS, 0.0), min(share + 1.0 / PARTS, 1.0)
    for _ in range(CLOSE_SEARCH):
        near, far = high - CLOSER * (high - low), low + CLOSER * (high - low)
        at_near = 1.0 * along(p, m, begin, edge, near)
        at_far = 1.0 * along(p, m, begin, edge, far)
        if at_near < at_far:
            high = far
        else:
            low = near
        if -min(at_near, at_far) > most:
            share, most = (near, -at_near) if at_near < at_far else (far, -at_far)
    return share, most


def deepest_of_all_places(p, m, begin, edge):
    """Return the same of all points of a segment, by golden-section search: the distance from a convex solid is convex
    along the segment. The error of the share is at most CLOSER^(SEARCH + 1), that of the depth this share of the
    segment's length, because its slope is at most 1."""
    low, high = 0.0, 1.0
    near, far = 1.0 - CLOSER, CLOSER
    if clears(p, m, begin, edge):
        return 1.0, -1.0 * INF
    at_near, at_far = 1.0 * along(p, m, begin, edge, near), 1.0 * along(p, m, begin, edge, far)
    for _ in range(SEARCH):
        if at_near < at_far:
            high, far, at_far = far, near, at_near
            near = high - CLOSER * (high - low)
            at_near = 1.0 * along(p, m, begin, edge, near)
        else:
            low, near, at_near = near, far, at_far
            far = low + CLOSER * (high - low)
            at_far = 1.0 * along(p, m, begin, edge, far)
    return (near, -at_near) if at_near < at_far else (far, -at_far)


@device
def put_segment_outside(p, m, begin, x, y, z):
    """Return the far end (x, y, z) of a segment, rotated until its deepest point is outside of solid m; the length
    stays the same."""
    ex, ey, ez = x - begin[0], y - begin[1], z - begin[2]
    size = ex * ex + ey * ey + ez * ez
    for _ in range(ROUNDS):
        share, under = deepest(p, m, begin, (ex, ey, ez))
        if under <= ZERO:
            break
        nx, ny, nz = normal(p, m, begin[0] + share * ex, begin[1] + share * ey, begin[2] + share * ez)
        under /= max(share, LEVER)
        ex, ey, ez = np.float32(ex + under * nx), np.float32(ey + under * ny), np.float32(ez + under * nz)
        keep = math.sqrt(size / max(ex * ex + ey * ey + ez * ez, TINY))
        ex, ey, ez = np.float32(keep * ex), np.float32(keep * ey), np.float32(keep * ez)
        x, y, z = begin[0] + ex, begin[1] + ey, begin[2] + ez
    return x, y, z


@device
def deepest_of_block(p, positions, b):
    """Return the greatest depth in these solids of a particle, except roots, of block b of positions
    (blocks, n + 1, 3 W), and of a point of its segments, of the first segment only what exceeds its root's; metres."""
    most = ZERO
    within = ZERO
    for i in range(2, positions.shape[1]):
        for k in range(W):
            x, y, z = positions[b, i - 1, k], positions[b, i - 1, W + k], positions[b, i - 1, 2 * W + k]
            qx, qy, qz = positions[b, i, k], positions[b, i, W + k], positions[b, i, 2 * W + k]
            size = math.sqrt((qx - x) * (qx - x) + (qy - y) * (qy - y) + (qz - z) * (qz - z))
            for m in range(p.rows.shape[0]):
                dx, dy, dz = qx - p.rows[m, X], qy - p.rows[m, Y], qz - p.rows[m, Z]
                reach = MARGIN * (p.rows[m, REACH] + size)
                if dx * dx + dy * dy + dz * dz > reach * reach:
                    continue  # all of the segment is outside of the solid's ball
                root = max(-distance(p, m, x, y, z), ZERO) if i == 2 else ZERO
                under = -distance(p, m, qx, qy, qz)
                _, depth = deepest(p, m, (x, y, z), (qx - x, qy - y, qz - z))
                most = max(most, under)
                within = np.float32(max(within, max(depth, under) - root))
    return most, within


@inlined
def deepen(p, x, y, z, most):
    """Return the greatest of the depths ``most`` and of those of points in these solids; vectors of lanes. Outside of a
    solid's bounding ball the depth is that in the ball."""
    for m in range(p.rows.shape[0]):
        dx, dy, dz = x - p.rows[m, X], y - p.rows[m, Y], z - p.rows[m, Z]
        under = p.rows[m, REACH] - sqrt(dx * dx + dy * dy + dz * dz)
        if any_lane(under > ZERO):
            u, v, w = own(p, m, x, y, z)
            under = where(under > ZERO, -distances_in_own(p, m, u, v, w), under)
        most = max(most, under)
    return most


@inlined
def nearest_slope_of_all(p, x, y, z):
    """Return the distances of points from the nearest of these solids, metres, and their gradients there; vectors of
    lanes."""
    least, gx, gy, gz = slope_in_world(p, 0, x, y, z)
    for m in range(1, p.rows.shape[0]):
        away, ax, ay, az = slope_in_world(p, m, x, y, z)
        nearer = away < least
        least, gx, gy, gz = min(least, away), where(nearer, ax, gx), where(nearer, ay, gy), where(nearer, az, gz)
    return least, gx, gy, gz


@inlined
def slope_in_world(p, m, x, y, z):
    """Return the distances of points from solid m, and their gradients in the world."""
    u, v, w = own(p, m, x, y, z)
    away, a, b, c = slopes_in_own(p, m, u, v, w)
    a, b, c = in_world(p, m, (a, b, c))
    return away, a, b, c
