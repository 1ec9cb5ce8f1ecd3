"""Strands as chains of equal segments, which solvers take: as long as the strands, from their roots to their tips.

Points at equal distances s along a strand are at most s apart, and less where it bends: a chain through all of them is
too short. So every other one is a joint, and what lies between two becomes an isosceles triangle with sides s on the
side on which the strand lies; or, once at the tip, a trapezoid, where the number of segments is odd. Both exist
whatever the strand is like, for an arc is no shorter than its chord.
"""

from __future__ import annotations

import math

from ...exchange.kernels.along import along, apart, distance
from ...jit import device, parallel, prange

STRAIGHT = 1e-20
"""Square of how far the strand lies beside a chord, over that of a segment, from which on it has a side."""


@parallel
def chains(first, points, low, share, out, deviation):
    """Chains on strands, few of them: first (G + 1,) int64 of points (P, 3); out (G, n, 3) float64, n ≥ 2; deviation
    (G,) float64, the greatest distance of a point from the chain; low (G, n) int64, share (G, n) float32: scratch.

    Joint k of a chain stands for the point at k / (n − 1) of its strand's length. A chain of one segment is the chord.
    """
    for g in prange(out.shape[0]):
        along(first, points, g, low, share, out)
        last = out.shape[1] - 1
        total = length(points, first[g], first[g + 1] - 1)
        k = 0
        while last - k > 1:
            end = last if last - k == 3 else k + 2
            fold(out[g], k, end, total / last)
            k = end
        deviation[g] = off(points, first[g], first[g + 1] - 1, out[g], total)


@device
def length(points, begin, end):
    """Of the polyline from point ``begin`` to ``end``."""
    total = 0.0
    for i in range(begin, end):
        total += distance(points, i, i + 1)
    return total


@device
def fold(out, k, end, size):
    """Place the joints between k and ``end``, one or two, so that all segments have a size; they are where the strand
    is, and the chord of those two is no longer than the segments together."""
    ex, ey, ez = out[end, 0] - out[k, 0], out[end, 1] - out[k, 1], out[end, 2] - out[k, 2]
    chord = math.sqrt(ex * ex + ey * ey + ez * ez)
    ex, ey, ez = (ex / chord, ey / chord, ez / chord) if chord > 0.0 else (0.0, 1.0, 0.0)
    sx, sy, sz = side_of(out, k, end, ex, ey, ez, size)
    ahead = 0.5 * (chord - (end - k - 2) * size)
    aside = math.sqrt(max(size * size - ahead * ahead, 0.0))
    for j in range(k + 1, end):
        t = ahead + (j - k - 1) * size
        out[j, 0] = out[k, 0] + t * ex + aside * sx
        out[j, 1] = out[k, 1] + t * ey + aside * sy
        out[j, 2] = out[k, 2] + t * ez + aside * sz


@device
def side_of(out, k, end, ex, ey, ez, size):
    """The unit vector across a unit vector e towards the mean of the points between k and ``end``, seen from the middle
    of these; any across where that is none."""
    x = y = z = 0.0
    for j in range(k + 1, end):
        x += out[j, 0] - 0.5 * (out[k, 0] + out[end, 0])
        y += out[j, 1] - 0.5 * (out[k, 1] + out[end, 1])
        z += out[j, 2] - 0.5 * (out[k, 2] + out[end, 2])
    for _ in range(2):  # once leaves rounding, of which little may be left where the strand is nearly straight
        t = x * ex + y * ey + z * ez
        x, y, z = x - t * ex, y - t * ey, z - t * ez
    if not x * x + y * y + z * z > STRAIGHT * size * size:  # across the axis that e is farthest from, too
        if abs(ex) <= min(abs(ey), abs(ez)):
            x, y, z = 0.0, ez, -ey
        elif abs(ey) <= abs(ez):
            x, y, z = -ez, 0.0, ex
        else:
            x, y, z = ey, -ex, 0.0
    scale = 1.0 / math.sqrt(x * x + y * y + z * z)
    return x * scale, y * scale, z * scale


@device
def off(points, begin, end, out, total):
    """Greatest distance of points ``begin`` to ``end`` of a strand from the segments of its chain that stand for it."""
    last = out.shape[0] - 1
    worst = 0.0
    passed = 0.0
    for i in range(begin, end + 1):
        if i > begin:
            passed += distance(points, i - 1, i)
        k = min(int(passed / total * last), last - 1) if total > 0.0 else 0
        worst = max(worst, apart(points, i, out, k, k + 1))
    return math.sqrt(worst)
