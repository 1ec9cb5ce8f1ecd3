"""Strands as chains of equal segments, which solvers take: their joints lie on the strands' polylines."""

from __future__ import annotations

import math

from ...exchange.kernels.along import apart, distance
from ...jit import device, parallel, prange

HALVINGS = 48
"""Of the range in which the length of a segment lies."""
SLACK = 1e-12
"""Share of a segment's length by which the last one may reach beyond the tip."""


@parallel
def chains(points, out, along, deviation):
    """Chains on strands (G, p, 3), G being few: out (G, n, 3) float64, whose segments are equally long, as long as lets
    all of them lie on the strand; along (G, n) float64, how far along the strand each joint is, in its own units; and
    deviation (G,) float64, the greatest distance of a point from the chain."""
    for g in prange(out.shape[0]):
        deviation[g] = chain(points[g], out[g], along[g])


@device
def chain(points, out, along):
    """`chains` of one strand; returns the deviation."""
    last = points.shape[0] - 1
    steps = out.shape[0] - 1
    high = 0.0
    for i in range(last):
        high += distance(points, i, i + 1)
    high /= steps
    low = distance(points, 0, last) / steps * (1.0 - SLACK)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if march(points, middle, out, along):
            low = middle
        else:
            high = middle
    march(points, low, out, along)
    return off(points, out, along)


@device
def march(points, size, out, along):
    """Place joints so far apart, the first at the root; False where the strand ends before the last."""
    last = points.shape[0] - 1
    x, y, z = float(points[0, 0]), float(points[0, 1]), float(points[0, 2])
    place(out, along, 0, x, y, z, 0.0)
    before = 0.0  # length of the strand up to its point i
    i = 0
    least = 0.0  # share of the segment from i on that is behind
    for k in range(1, out.shape[0]):
        found = False
        while i < last:
            ex = float(points[i + 1, 0]) - points[i, 0]
            ey = float(points[i + 1, 1]) - points[i, 1]
            ez = float(points[i + 1, 2]) - points[i, 2]
            bx, by, bz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
            a = ex * ex + ey * ey + ez * ez
            b = ex * bx + ey * by + ez * bz
            c = bx * bx + by * by + bz * bz - size * size
            root = b * b - a * c
            if a > 0.0 and root >= 0.0:
                t = (-b + math.sqrt(root)) / a
                if least <= t <= 1.0:
                    x, y, z = points[i, 0] + t * ex, points[i, 1] + t * ey, points[i, 2] + t * ez
                    place(out, along, k, x, y, z, before + t * math.sqrt(a))
                    least = t
                    found = True
                    break
            before += math.sqrt(a)
            least = 0.0
            i += 1
        if not found:
            return False
    return True


@device
def place(out, along, k, x, y, z, way):
    """Write joint k."""
    out[k, 0] = x
    out[k, 1] = y
    out[k, 2] = z
    along[k] = way


@device
def off(points, out, along):
    """Greatest distance of a strand's points from the segments of its chain that go with them."""
    worst = 0.0
    way = 0.0
    k = 0
    for i in range(points.shape[0]):
        if i > 0:
            way += distance(points, i - 1, i)
        while k < out.shape[0] - 2 and along[k + 1] < way:
            k += 1
        worst = max(worst, apart(points, i, out, k, k + 1))
    return math.sqrt(worst)
