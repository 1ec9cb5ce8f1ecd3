"""Strands that follow simulated ones: where every point of a strand goes when its guides move.

A guide that was at g°(u) at rest and now is at g(u) has moved by D(u) = g(u) − g°(u) and turned by q(u), at the share
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
from ...simd.vectors import add_scaled, cross, dot, less, scaled, sum_of
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
    """Write a table (G, T, `COLUMNS`) of guides at positions (blocks, n + 1, 3 W), which were at ``rest`` in the same
    layout; turn (G, 4) the rotations at their roots, unit quaternions with their real parts first."""
    for g in prange(table.shape[0]):
        turns = np.empty((rest.shape[1] - 1, 4), np.float64)
        trace(positions[g // W], rest[g // W], g % W, turn[g], turns, table[g])


@device
def trace(now, rest, lane, turn, turns, table):
    """`motions` of one guide; turns (n, 4): scratch for the rotations at its particles."""
    n = now.shape[0] - 1
    own = turn[0], (turn[1], turn[2], turn[3])
    put(turns, 0, own)
    for j in range(1, n):  # the edge that ends at particle j
        past = own
        own = onward(turned(own, edge(rest, j, lane)), edge(now, j, lane), own)
        if j > 1:
            put(turns, j - 1, (past[0] + own[0], sum_of(past[1], own[1])))
        put(turns, j, own)
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
def put(turns, j, turn):
    """Write a quaternion, its real part and its vector, made a unit, into row j."""
    w, (x, y, z) = turn
    size = 1.0 / math.sqrt(max(w * w + x * x + y * y + z * z, 1e-300))
    turns[j, 0], turns[j, 1], turns[j, 2], turns[j, 3] = w * size, x * size, y * size, z * size


@device
def edge(rows, j, lane):
    """Unit vector from particle j − 1 to j."""
    x = np.float64(rows[j + 1, lane]) - rows[j, lane]
    y = np.float64(rows[j + 1, W + lane]) - rows[j, W + lane]
    z = np.float64(rows[j + 1, 2 * W + lane]) - rows[j, 2 * W + lane]
    return scaled(1.0 / math.sqrt(max(x * x + y * y + z * z, 1e-300)), (x, y, z))


@device
def turned(turn, a):
    """A vector turned by a unit quaternion."""
    w, v = turn
    u = scaled(2.0, cross(v, a))
    return sum_of(add_scaled(a, w, u), cross(v, u))


@device
def onward(a, b, turn):
    """A rotation, and after it the least one that takes the unit vector a to b."""
    r, u = 1.0 + dot(a, b), cross(a, b)
    if r < FOLDED:  # a half turn about any direction across
        r, u = 0.0, ((0.0, a[2], -a[1]) if abs(a[0]) < 0.5 else (-a[2], 0.0, a[0]))
    size = 1.0 / math.sqrt(r * r + dot(u, u))
    r, u = r * size, scaled(size, u)
    w, v = turn
    return r * w - dot(u, v), sum_of(add_scaled(scaled(r, v), w, u), cross(u, v))


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
    before = past = added = ZERO, ZERO, ZERO
    whole = own = ZERO
    for j in range(points.shape[1]):
        here = points[i, j, X], points[i, j, Y], points[i, j, Z]
        now = moved(strands, i, points[i, j, SHARE], table, total, here)
        if j > 0:
            rest, step = size(less(here, before)), less(now, past)
            length = size(step)
            whole += rest
            own += length
            begin = sum_of(past, added)
            added = add_scaled(added, (rest - length) / max(length, TINY), step)
            if solid:
                x, y, z = sum_of(now, added)
                u, v, w = keep_out(x, y, z, begin[0], begin[1], begin[2], rest, solids)
                if u != x or v != y or w != z:
                    added = less((u, v, w), now)
        before, past = here, now
        out[b, j + 1, lane], out[b, j + 1, W + lane], out[b, j + 1, 2 * W + lane] = sum_of(now, added)
    for c in range(3):
        k = c * W + lane
        out[b, 0, k] = TWO * out[b, 1, k] - out[b, 2, k]
    return abs(own - whole) / max(whole, TINY)


@device
def moved(strands, i, share, table, total, here):
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
            first, second = weight * (ONE - part), weight * part
            for c in range(COLUMNS):
                total[c] += first * table[g, row, c] + second * table[g, row + 1, c]
    d = less(here, (total[REST], total[REST + 1], total[REST + 2]))
    w, v = total[TURN], (total[TURN + 1], total[TURN + 2], total[TURN + 3])
    f = TWO / max(w * w + v[0] * v[0] + v[1] * v[1] + v[2] * v[2], TINY)
    a = cross(v, d)
    turn = scaled(f, sum_of(scaled(w, a), cross(v, a)))
    return sum_of(here, sum_of((total[SHIFT], total[SHIFT + 1], total[SHIFT + 2]), turn))


@device
def size(a):
    """A vector's length."""
    return math.sqrt(dot(a, a))
