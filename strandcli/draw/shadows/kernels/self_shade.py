"""Which parts of a strand its own pieces shade.

A strand's scattering already has the strand's own body in it, so what lies in the way within a strand's reach of a
place is no shadow. What counts is the way along the strand: a piece does not shade a place if the strand, from the
place up to that piece, stays within some widths of the ray from the light to the place. A strand that turns away and
comes back before itself does shade itself. A strand that points to the light is all its length behind itself, but
within its own width.

Of a straight piece the places that are within a distance of a vertex, seen from the light, are one interval, and the
places from which all vertices up to a piece are so near are the intervals' common part.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device
from ...common.kernels.view_columns import EYE_X, EYE_Y, EYE_Z, FORWARD_X, FORWARD_Y, FORWARD_Z, PERSPECTIVE

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)


@device
def own_pieces(world, a, n, p, views, apart, parts):
    """From which to which first vertex pieces lie that do not shade some part of piece p of the same strand, whose n
    pieces begin with vertex a; into parts (n, 2): which part, places t ∈ [0, 1] along piece p. Of piece p itself it is
    the whole. world (V, 3), apart: metres; views: of the light."""
    parts[p, 0] = ZERO
    parts[p, 1] = ONE
    x, y, z = direction(world, a + p + 1, views)
    begin = ZERO
    end = ONE
    high = p
    while high < n - 1:
        begin, end = near_vertex(world, a + p, a + high + 1, x, y, z, apart, begin, end)
        if begin >= end:
            break
        high += 1
        parts[high, 0] = begin
        parts[high, 1] = end
    x, y, z = direction(world, a + p, views)
    begin = ZERO
    end = ONE
    low = p
    while low > 0:
        begin, end = near_vertex(world, a + p, a + low, x, y, z, apart, begin, end)
        if begin >= end:
            break
        low -= 1
        parts[low, 0] = begin
        parts[low, 1] = end
    return a + low, a + high


@device
def direction(world, v, views):
    """Unit vector along the light's ray through a vertex."""
    near = views[0, PERSPECTIVE] > ZERO
    x = views[0, EYE_X] - world[v, 0] if near else views[0, FORWARD_X]
    y = views[0, EYE_Y] - world[v, 1] if near else views[0, FORWARD_Y]
    z = views[0, EYE_Z] - world[v, 2] if near else views[0, FORWARD_Z]
    per = ONE / math.sqrt(max(x * x + y * y + z * z, TINY))
    return x * per, y * per, z * per


@device
def near_vertex(world, v, w, x, y, z, apart, begin, end):
    """The places t of the piece after vertex v, of those from `begin` to `end`, whose distance from vertex w is less
    than `apart` aside of the direction (x, y, z). Where there are none they end where they begin, or before."""
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
    """The way from vertex w to vertex v, less what of it is along the direction (x, y, z)."""
    dx = world[v, 0] - world[w, 0]
    dy = world[v, 1] - world[w, 1]
    dz = world[v, 2] - world[w, 2]
    along = dx * x + dy * y + dz * z
    return dx - along * x, dy - along * y, dz - along * z
