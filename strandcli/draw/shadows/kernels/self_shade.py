"""Self-shadowing: the parts of a strand's segments that its own other segments shade.

The fibre model already accounts for the strand's own body, so the strand near a point must not shade that point. A
segment does not shade a point if the strand, from the point to that segment, stays within some widths of the ray from
the light to the point. So a strand that turns away and comes back in front of itself does shade itself, and one that
points at the light, which is behind itself all along, does not.

The points of a straight segment within a given lateral distance of a vertex, seen from the light, are one interval. The
points from which all vertices up to some segment are that near are the intersection of these intervals.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device
from ...common.kernels.view_columns import EYE_X, EYE_Y, EYE_Z, FORWARD_X, FORWARD_Y, FORWARD_Z, PERSPECTIVE

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)
BEGIN, END = 0, 1
"""Columns of the unshaded parts."""


@device
def own_pieces(world, a, n, p, views, apart, parts):
    """Return the first vertices of the first and last segment that leave a part of segment p unshaded, and write these
    parts, intervals t ∈ [0, 1] of segment p, to parts (n, 2).

    a: first vertex of the strand; n: number of its segments; world (V, 3), apart: metres; views: of the light. No part
    of segment p is shaded by itself."""
    parts[p, BEGIN] = ZERO
    parts[p, END] = ONE
    x, y, z = direction(world, a + p + 1, views)
    begin = ZERO
    end = ONE
    high = p
    while high < n - 1:
        begin, end = near_vertex(world, a + p, a + high + 1, x, y, z, apart, begin, end)
        if begin >= end:
            break
        high += 1
        parts[high, BEGIN] = begin
        parts[high, END] = end
    x, y, z = direction(world, a + p, views)
    begin = ZERO
    end = ONE
    low = p
    while low > 0:
        begin, end = near_vertex(world, a + p, a + low, x, y, z, apart, begin, end)
        if begin >= end:
            break
        low -= 1
        parts[low, BEGIN] = begin
        parts[low, END] = end
    return a + low, a + high


@device
def direction(world, v, views):
    """Return the unit vector along the light's ray through vertex v."""
    near = views[0, PERSPECTIVE] > ZERO
    x = views[0, EYE_X] - world[v, 0] if near else views[0, FORWARD_X]
    y = views[0, EYE_Y] - world[v, 1] if near else views[0, FORWARD_Y]
    z = views[0, EYE_Z] - world[v, 2] if near else views[0, FORWARD_Z]
    per = ONE / math.sqrt(max(x * x + y * y + z * z, TINY))
    return x * per, y * per, z * per


@device
def near_vertex(world, v, w, x, y, z, apart, begin, end):
    """Return the part of the interval begin <= t <= end of the segment after vertex v whose distance from vertex w,
    perpendicular to the direction (x, y, z), is less than `apart`. If it is empty, its end is not greater than its
    beginning."""
    dx, dy, dz = aside(world, v + 1, v, x, y, z)
    ex, ey, ez = aside(world, v, w, x, y, z)
    square = dx * dx + dy * dy + dz * dz
    nearest = -(dx * ex + dy * ey + dz * ez) / square if square > TINY else ZERO
    ex += nearest * dx
    ey += nearest * dy
    ez += nearest * dz
    room = apart * apart - (ex * ex + ey * ey + ez * ez)
    if not room > ZERO:
        return begin, begin
    if not square > TINY:
        return begin, end
    reach = math.sqrt(room / square)
    return max(begin, nearest - reach), min(end, nearest + reach)


@device
def aside(world, v, w, x, y, z):
    """Return the component of the vector from vertex w to vertex v perpendicular to the unit direction (x, y, z)."""
    dx = world[v, 0] - world[w, 0]
    dy = world[v, 1] - world[w, 1]
    dz = world[v, 2] - world[w, 2]
    along = dx * x + dy * y + dz * z
    return dx - along * x, dy - along * y, dz - along * z
