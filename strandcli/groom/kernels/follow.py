"""Strands that follow simulated ones: where every point of a strand goes when its guides move.

A guide that lay at g°(u) at rest and now lies at g(u) has moved by D(u) = g(u) − g°(u) and turned by q(u), at the share
u of its length. A strand's point x° at rest goes to

    x = x° + D + (q d q* − d),   d = x° − g°,

with D, q and g° those of its guides at u, weighted. So what a strand has beyond its guides, such as curls, turns with
them; where all guides move as one rigid thing so does the strand; and where none moves, each point keeps its bits.
Segments then get the length again that they have at rest, root to tip, in the direction that they have now.

A strand shorter than a guide follows the part near its root that is as long; u of a longer one is the share of its own
length. Rotations follow from the guides' edges: that of an edge is that of the edge before and then the least one that
takes it to where the edge is (parallel transport); at the root it is the emitter's.

A row of a table holds D, g° and q of a guide, at equal distances along it. G: guides; n: their particles; T: rows.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...jit import device, parallel, prange
from ...solids.kernels.outside import count as count_solids
from .keep_out import keep_out

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
TINY = np.float32(1e-30)
X, Y, Z, SHARE = 0, 1, 2, 3
"""Columns of a strand's points."""
SHIFT, REST, TURN, COLUMNS = 0, 3, 6, 12
"""First columns of D, g° and q in a row, and how many there are: three vectors of four, of which two are not used."""
FOLDED = 1e-9
"""1 + cos of the angle between two directions below which they are opposite."""


class Strands(NamedTuple):
    """Strands at rest, and what they follow. k: those that are there; P: guides of each."""

    points: NDArray[np.float32]
    """(k, m, 4) metres at rest, in the world, and how far along the strand each point is, as a share of its length."""
    parents: NDArray[np.int32]
    """(k, P)"""
    weights: NDArray[np.float32]
    """(k, P), 1 together."""
    reaches: NDArray[np.float32]
    """(k, P) share of each guide's length that the strand follows."""


@parallel
def motions(positions, rest, turn, table):
    """Write a table (G, T, `COLUMNS`) of guides at positions (blocks, n + 1, 3 W), which lay at ``rest`` in the same
    layout; turn (G, 4) the rotations at their roots, unit quaternions with their real parts first."""
    for g in prange(table.shape[0]):
        turns = np.empty((rest.shape[1] - 1, 4), np.float64)
        trace(positions[g // W], rest[g // W], g % W, turn[g], turns, table[g])


@device
def trace(now, rest, lane, turn, turns, table):
    """`motions` of one guide; turns (n, 4): scratch for the rotations at its particles."""
    n = now.shape[0] - 1
    w, x, y, z = turn[0], turn[1], turn[2], turn[3]
    put(turns, 0, w, x, y, z)
    for j in range(1, n):  # the edge that ends at particle j
        ax, ay, az = edge(rest, j, lane)
        ax, ay, az = turned(w, x, y, z, ax, ay, az)
        bx, by, bz = edge(now, j, lane)
        pw, px, py, pz = w, x, y, z
        w, x, y, z = onward(ax, ay, az, bx, by, bz, w, x, y, z)
        if j > 1:
            put(turns, j - 1, pw + w, px + x, py + y, pz + z)
        put(turns, j, w, x, y, z)
    for row in range(table.shape[0]):
        at = row * (n - 1) / (table.shape[0] - 1)
        j = min(int(at), n - 2)
        t = at - j
        for c in range(3):
            k = c * W + lane
            old = moved = 0.0
            for i in range(4):
                one = min(max(j - 1 + i, 0), n - 1) + 1
                weight = cubic(i, j, n, t)
                old += weight * np.float64(rest[one, k])
                moved += weight * (np.float64(now[one, k]) - rest[one, k])
            table[row, SHIFT + c] = moved
            table[row, REST + c] = old
        for c in range(4):
            table[row, TURN + c] = turns[j, c] + t * (turns[j + 1, c] - turns[j, c])
        table[row, TURN + 4] = table[row, TURN + 5] = ZERO


@device
def cubic(i, j, n, t):
    """Weight of the particle j − 1 + i at t between j and j + 1 (Catmull and Rom 1974); at the ends of a strand the
    difference is one-sided."""
    before = t * (1.0 - t) * (1.0 - t)  # of the derivative at j, and after of that at j + 1
    after = t * t * (t - 1.0)
    share = t * t * (3.0 - 2.0 * t)
    first = 0.5 if j > 0 else 1.0
    last = 0.5 if j + 2 < n else 1.0
    if i == 0:
        return -first * before if j > 0 else 0.0
    if i == 1:
        return 1.0 - share - last * after - (before if j == 0 else 0.0)
    if i == 2:
        return share + first * before + (after if j + 2 >= n else 0.0)
    return last * after if j + 2 < n else 0.0


@device
def put(turns, j, w, x, y, z):
    """Write a quaternion, made a unit, into row j."""
    size = 1.0 / math.sqrt(max(w * w + x * x + y * y + z * z, 1e-300))
    turns[j, 0] = w * size
    turns[j, 1] = x * size
    turns[j, 2] = y * size
    turns[j, 3] = z * size


@device
def edge(rows, j, lane):
    """Unit vector from particle j − 1 to j."""
    x = np.float64(rows[j + 1, lane]) - rows[j, lane]
    y = np.float64(rows[j + 1, W + lane]) - rows[j, W + lane]
    z = np.float64(rows[j + 1, 2 * W + lane]) - rows[j, 2 * W + lane]
    size = 1.0 / math.sqrt(max(x * x + y * y + z * z, 1e-300))
    return x * size, y * size, z * size


@device
def turned(w, x, y, z, a, b, c):
    """A vector (a, b, c) turned by a unit quaternion."""
    u = 2.0 * (y * c - z * b)
    v = 2.0 * (z * a - x * c)
    t = 2.0 * (x * b - y * a)
    return a + w * u + (y * t - z * v), b + w * v + (z * u - x * t), c + w * t + (x * v - y * u)


@device
def onward(ax, ay, az, bx, by, bz, w, x, y, z):
    """The rotation (w, x, y, z), and after it the least one that takes the unit vector a to b."""
    r = 1.0 + ax * bx + ay * by + az * bz
    u = ay * bz - az * by
    v = az * bx - ax * bz
    t = ax * by - ay * bx
    if r < FOLDED:  # a half turn about any direction across
        r = 0.0
        if abs(ax) < 0.5:
            u, v, t = 0.0, az, -ay
        else:
            u, v, t = -az, 0.0, ax
    size = 1.0 / math.sqrt(r * r + u * u + v * v + t * t)
    r *= size
    u *= size
    v *= size
    t *= size
    return (
        r * w - u * x - v * y - t * z,
        r * x + u * w + v * z - t * y,
        r * y + v * w + t * x - u * z,
        r * z + t * w + u * y - v * x,
    )


@parallel
def follow(strands, table, solids, out, stretch):
    """Place `Strands` by a table of their guides (G, T, `COLUMNS`): out (blocks, m + 1, 3 W) metres, outside of packed
    `Solids`, the last block padded with copies of the last strand; stretch (blocks,): the greatest share by which a
    strand's length had changed before its segments got theirs back."""
    count = strands.parents.shape[0]
    for block in prange(out.shape[0]):
        b = np.int64(block)
        worst = ZERO
        total = np.empty(COLUMNS, np.float32)
        for lane in range(W):
            i = min(b * W + lane, count - 1)
            worst = max(worst, carry(strands, i, b, lane, table, solids, total, out))
        stretch[b] = worst


@device
def carry(strands, i, b, lane, table, solids, total, out):
    """`follow` of strand i, in a lane of block b; returns its stretch. total (COLUMNS,): scratch."""
    points = strands.points
    solid = count_solids(solids) > 0
    # the strand at rest, as its guides alone would have it, and what is added so that lengths are kept
    ox = oy = oz = px = py = pz = cx = cy = cz = ZERO
    whole = own = ZERO
    for j in range(points.shape[1]):
        x = points[i, j, X]
        y = points[i, j, Y]
        z = points[i, j, Z]
        ax, ay, az = moved(strands, i, points[i, j, SHARE], table, total, x, y, z)
        if j > 0:
            rest = size(x - ox, y - oy, z - oz)
            now = size(ax - px, ay - py, az - pz)
            whole += rest
            own += now
            f = (rest - now) / max(now, TINY)
            fx = px + cx
            fy = py + cy
            fz = pz + cz
            cx += f * (ax - px)
            cy += f * (ay - py)
            cz += f * (az - pz)
            if solid:
                qx, qy, qz = keep_out(ax + cx, ay + cy, az + cz, fx, fy, fz, rest, solids)
                if qx != ax + cx or qy != ay + cy or qz != az + cz:
                    cx = qx - ax
                    cy = qy - ay
                    cz = qz - az
        ox = x
        oy = y
        oz = z
        px = ax
        py = ay
        pz = az
        out[b, j + 1, lane] = ax + cx
        out[b, j + 1, W + lane] = ay + cy
        out[b, j + 1, 2 * W + lane] = az + cz
    for c in range(3):
        k = c * W + lane
        out[b, 0, k] = TWO * out[b, 1, k] - out[b, 2, k]
    return abs(own - whole) / max(whole, TINY)


@device
def moved(strands, i, share, table, total, x, y, z):
    """Where the guides of strand i take a point of it; total (COLUMNS,): scratch."""
    steps = np.float32(table.shape[1] - 1)
    for c in range(COLUMNS):
        total[c] = ZERO
    for p in range(strands.parents.shape[1]):
        weight = strands.weights[i, p]
        if weight > ZERO:
            g = strands.parents[i, p]
            place = share * strands.reaches[i, p] * steps
            row = min(np.int64(place), table.shape[1] - 2)
            part = place - np.float32(row)
            less = weight * (ONE - part)
            more = weight * part
            for c in range(COLUMNS):
                total[c] += less * table[g, row, c] + more * table[g, row + 1, c]
    dx = x - total[REST]
    dy = y - total[REST + 1]
    dz = z - total[REST + 2]
    w = total[TURN]
    u = total[TURN + 1]
    v = total[TURN + 2]
    t = total[TURN + 3]
    f = TWO / max(w * w + u * u + v * v + t * t, TINY)
    ax = v * dz - t * dy
    ay = t * dx - u * dz
    az = u * dy - v * dx
    x += total[SHIFT] + f * (w * ax + (v * az - t * ay))
    y += total[SHIFT + 1] + f * (w * ay + (t * ax - u * az))
    z += total[SHIFT + 2] + f * (w * az + (u * ay - v * ax))
    return x, y, z


@device
def size(x, y, z):
    """A vector's length."""
    return math.sqrt(x * x + y * y + z * z)
