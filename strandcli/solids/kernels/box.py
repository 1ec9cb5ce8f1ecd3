"""Compiled functions of boxes: as `sphere`; `p` holds packed boxes."""

from __future__ import annotations

from typing import Any

from ...constants import W
from ...jit import device, inlined
from ...simd import broadcast, sqrt, where
from ..shapes.box import HALF, ROW_X, ROW_Y, ROW_Z, X, Y, Z
from .sphere import INF, ONE, TINY, ZERO

NONE = 1e-30
"""Least divisor: slope along a segment."""
EQUAL = 1e-3
"""Difference of depths below two faces that counts as none, in how much deeper the segment gets below both."""
LEVEL = 1e-5
"""Difference of depths along a segment that counts as none, over its length."""
DEEPEST = 1e20
"""Greater than any depth, metres."""


@device
def meet(p, m, ox, oy, oz, dx, dy, dz):
    """Return the distance as `sphere.meet`, by slabs (Kay & Kajiya 1986)."""
    cx = ox - p[m, X]
    cy = oy - p[m, Y]
    cz = oz - p[m, Z]
    enter = -INF
    leave = INF
    for k in range(3):
        o = p[m, ROW_X + k] * cx + p[m, ROW_Y + k] * cy + p[m, ROW_Z + k] * cz
        d = p[m, ROW_X + k] * dx + p[m, ROW_Y + k] * dy + p[m, ROW_Z + k] * dz
        if abs(d) < TINY:
            if abs(o) > p[m, HALF + k]:
                return INF
            continue
        near = (-p[m, HALF + k] - o) / d
        far = (p[m, HALF + k] - o) / d
        enter = max(enter, min(near, far))
        leave = min(leave, max(near, far))
    if enter > leave:
        return INF
    return enter


@device
def normal(p, m, x, y, z):
    """Return the outward unit normal of the face that contains a point."""
    cx = x - p[m, X]
    cy = y - p[m, Y]
    cz = z - p[m, Z]
    face = 0
    most = -INF
    side = ONE
    for k in range(3):
        u = p[m, ROW_X + k] * cx + p[m, ROW_Y + k] * cy + p[m, ROW_Z + k] * cz
        over = abs(u) - p[m, HALF + k]
        if over > most:
            most = over
            face = k
            side = ONE if u > ZERO else -ONE
    return side * p[m, ROW_X + face], side * p[m, ROW_Y + face], side * p[m, ROW_Z + face]


@device
def outside(p, m, x, y, z, clear):
    """Return a point, moved to `clear` metres from the nearest face if it is nearer or inside."""
    least = INF
    face = 0
    side = ONE
    for k in range(3):
        u = p[m, ROW_X + k] * (x - p[m, X]) + p[m, ROW_Y + k] * (y - p[m, Y])
        u += p[m, ROW_Z + k] * (z - p[m, Z])
        under = p[m, HALF + k] + clear - abs(u)
        if under < least:
            least = under
            face = k
            side = ONE if u >= ZERO else -ONE
    deep = side * max(least, ZERO)
    return x + deep * p[m, ROW_X + face], y + deep * p[m, ROW_Y + face], z + deep * p[m, ROW_Z + face]


@device
def own(p, m, k, x, y, z):
    """Return the component of vectors along axis k of box m; vectors of lanes."""
    return p[m + ROW_X + k] * x + p[m + ROW_Y + k] * y + p[m + ROW_Z + k] * z


@device
def depth(p, m, x, y, z):
    """Return the depth of points below the nearest face of box m, and that face's unit normal in the world; vectors of
    lanes."""
    dx = x - p[m + X]
    dy = y - p[m + Y]
    dz = z - p[m + Z]
    best = broadcast(x, DEEPEST)
    nx = broadcast(x, 0.0)
    ny = broadcast(x, 1.0)
    nz = nx
    for k in range(3):
        u = own(p, m, k, dx, dy, dz)
        under = p[m + HALF + k] - abs(u)
        nearer = under < best
        best = where(nearer, under, best)
        sign = where(u >= 0.0, broadcast(x, 1.0), -1.0)
        nx = where(nearer, sign * p[m + ROW_X + k], nx)
        ny = where(nearer, sign * p[m + ROW_Y + k], ny)
        nz = where(nearer, sign * p[m + ROW_Z + k], nz)
    return best, nx, ny, nz


@inlined
def below_faces(p, m, u, v, w):
    """Return the depth below the nearest face of a point in the box's own frame."""
    return min(min(p[m + HALF] - abs(u), p[m + HALF + 1] - abs(v)), p[m + HALF + 2] - abs(w))


@inlined
def least_depth(p, m, x, y, z):
    """Return the depth of points below the nearest face of box m; vectors of lanes."""
    u, v, w = own_place(p, m, (x, y, z))
    return below_faces(p, m, u, v, w)


@device
def segment_depth(p, m, start, edge):
    """Return the depth as `sphere.segment_depth`; if negative, it is not a distance."""
    return deepest_place(p, m, start, edge, 0.0)[0]


@device
def deepest_place(p, m, start, edge, first):
    """Return the depth of the deepest place of a segment, from a share ``first`` of it on, and where that is. Depths
    below the six faces are linear along the segment, so their minimum is greatest at an end, midway between opposite
    faces, or at equal distances from two solids."""
    x, y, z = start[0] - p[m + X], start[1] - p[m + Y], start[2] - p[m + Z]
    u, v, w = own(p, m, 0, x, y, z), own(p, m, 1, x, y, z), own(p, m, 2, x, y, z)
    du, dv = own(p, m, 0, edge[0], edge[1], edge[2]), own(p, m, 1, edge[0], edge[1], edge[2])
    dw = own(p, m, 2, edge[0], edge[1], edge[2])
    most, share = below_faces(p, m, u + du, v + dv, w + dw), broadcast(u, 1.0)
    level = LEVEL * (abs(du) + abs(dv) + abs(dw))
    for k in range(-1, 15):
        if k < 0:
            at, slope = broadcast(u, 0.0), du
        elif k < 3:
            at = u if k == 0 else (v if k == 1 else w)
            slope = du if k == 0 else (dv if k == 1 else dw)
        else:  # equally far from one face of each of two pairs: half − sign a = other − side b
            pair = (k - 3) // 4
            a, da, half = (u, du, p[m + HALF]) if pair < 2 else (v, dv, p[m + HALF + 1])
            b, db, other = (v, dv, p[m + HALF + 1]) if pair == 0 else (w, dw, p[m + HALF + 2])
            sign = 1.0 if k % 4 < 2 else -1.0
            side = 1.0 if k % 2 == 0 else -1.0
            at, slope = sign * a - side * b - (half - other), sign * da - side * db
        steep = abs(slope) > NONE
        t = min(max(where(steep, -at / where(steep, slope, 1.0), 0.0), first), 1.0)
        under = below_faces(p, m, u + t * du, v + t * dv, w + t * dw)
        deeper = under > most + level  # else the share of a segment that lies on a face would be rounding's
        share = where(deeper, t, share)
        most = where(deeper, under, most)
    return most, share


@device
def touch(p, m, start, end, first):
    """Return the depth of the deepest place of a segment in box m, the unit normal of the way out, and where on the
    segment that is, from a share ``first`` on. A segment that enters by a face and leaves by another one cuts off an
    edge of the box; the way out is perpendicular to both."""
    ex, ey, ez = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    _, t = deepest_place(p, m, start, (ex, ey, ez), first)
    x, y, z = own_place(p, m, (start[0] + t * ex, start[1] + t * ey, start[2] + t * ez))
    under, second = broadcast(t, DEEPEST), broadcast(t, DEEPEST)
    none = broadcast(t, 0.0)
    face, next, slope, next_slope = (none, none, none), (none, none, none), none, none
    for k in range(3):
        at = x if k == 0 else (y if k == 1 else z)
        sign = where(at >= 0.0, broadcast(t, 1.0), -1.0)
        deep = p[m + HALF + k] - abs(at)
        steep = sign * own(p, m, k, ex, ey, ez)
        normal = sign * p[m + ROW_X + k], sign * p[m + ROW_Y + k], sign * p[m + ROW_Z + k]
        least, less = deep < under, deep < second
        second = where(least, under, where(less, deep, second))
        next_slope = where(least, slope, where(less, steep, next_slope))
        next = chosen(least, face, chosen(less, normal, next))
        under = where(least, deep, under)
        slope = where(least, steep, slope)
        face = chosen(least, normal, face)
    # the place is as far from both faces, of which the segment enters one and leaves the other
    cut = (
        (t > first) & (t < 1.0) & (slope * next_slope < 0.0) & (second - under < EQUAL * (abs(slope) + abs(next_slope)))
    )
    a, b = abs(next_slope), abs(slope)
    size = 1.0 / sqrt(max(a * a + b * b, NONE))
    a, b = where(cut, a * size, 1.0), where(cut, b * size, 0.0)
    depth = a * under + b * second
    return depth, (a * face[0] + b * next[0], a * face[1] + b * next[1], a * face[2] + b * next[2]), t


@inlined
def chosen(lanes, a, b):
    """Return vector a in some lanes, b in the rest."""
    return where(lanes, a[0], b[0]), where(lanes, a[1], b[1]), where(lanes, a[2], b[2])


@inlined
def own_place(p, m, at):
    """Return points in the box's own frame; vectors of lanes."""
    x, y, z = at[0] - p[m + X], at[1] - p[m + Y], at[2] - p[m + Z]
    return own(p, m, 0, x, y, z), own(p, m, 1, x, y, z), own(p, m, 2, x, y, z)


def collide(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """Move particles inside of boxes to the nearest face, as `sphere.collide`."""
    for s in range(p.shape[0]):
        for k in range(W):
            dx = x[k] - p[s, X]
            dy = x[W + k] - p[s, Y]
            dz = x[2 * W + k] - p[s, Z]
            u = p[s, ROW_X] * dx + p[s, ROW_Y] * dy + p[s, ROW_Z] * dz
            v = p[s, ROW_X + 1] * dx + p[s, ROW_Y + 1] * dy + p[s, ROW_Z + 1] * dz
            w = p[s, ROW_X + 2] * dx + p[s, ROW_Y + 2] * dy + p[s, ROW_Z + 2] * dz
            du = p[s, HALF] - abs(u)
            dv = p[s, HALF + 1] - abs(v)
            dw = p[s, HALF + 2] - abs(w)
            least = min(du, min(dv, dw))
            inside = max(least, ZERO)
            by_u = inside if du <= least else ZERO
            by_v = inside if (dv <= least) and (du > least) else ZERO
            by_w = inside - by_u - by_v
            by_u = by_u if u >= ZERO else -by_u
            by_v = by_v if v >= ZERO else -by_v
            by_w = by_w if w >= ZERO else -by_w
            x[k] += p[s, ROW_X] * by_u + p[s, ROW_X + 1] * by_v + p[s, ROW_X + 2] * by_w
            x[W + k] += p[s, ROW_Y] * by_u + p[s, ROW_Y + 1] * by_v + p[s, ROW_Y + 2] * by_w
            x[2 * W + k] += p[s, ROW_Z] * by_u + p[s, ROW_Z + 1] * by_v + p[s, ROW_Z + 2] * by_w
