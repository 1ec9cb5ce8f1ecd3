"""Points along strands, by arc length.

A strand is the polyline of its points. Distances are in the units of the points, and in double precision.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import device, parallel, prange


@parallel
def resample(first, points, low, share, out, deviation):
    """Points at equal distances along strands: first (S + 1,) int64 of points (P, 3); out (S, n, 3) is written, roots
    and tips as they were, and deviation (S,) float64, the largest distance of an old point from the new polyline.

    Each new point lies between the old points low (S, n) int64 and low + 1, at share (S, n) float32; both are written.
    """
    for s in prange(out.shape[0]):
        deviation[s] = along(first, points, s, low, share, out)


@device
def along(first, points, s, low, share, out):
    """`resample` of strand s; returns its deviation."""
    begin = first[s]
    end = first[s + 1] - 1
    last = out.shape[1] - 1
    total = 0.0
    for i in range(begin, end):
        total += distance(points, i, i + 1)
    travelled = 0.0
    k = 0
    for i in range(begin, end):
        step = distance(points, i, i + 1)
        while k < last and total * k <= (travelled + step) * last:
            t = (total * k / last - travelled) / step if step > 0.0 else 0.0
            put(points, i, min(max(t, 0.0), 1.0), low, share, out, s, k)
            k += 1
        travelled += step
    while k <= last:
        put(points, end - 1, 1.0, low, share, out, s, k)
        k += 1
    worst = 0.0
    travelled = 0.0
    for i in range(begin + 1, end):
        travelled += distance(points, i - 1, i)
        k = min(int(travelled / total * last), last - 1) if total > 0.0 else 0
        worst = max(worst, math.sqrt(apart(points, i, out[s], k, k + 1)))
    return worst


@device
def put(points, i, t, low, share, out, s, k):
    """Write new point k of strand s, at t between the old points i and i + 1."""
    low[s, k] = i
    share[s, k] = t
    for c in range(3):
        a = np.float64(points[i, c])
        out[s, k, c] = points[i + 1, c] if t == 1.0 else a + t * (points[i + 1, c] - a)


@device
def distance(points, i, j):
    """From point i to point j."""
    x = np.float64(points[j, 0]) - points[i, 0]
    y = np.float64(points[j, 1]) - points[i, 1]
    z = np.float64(points[j, 2]) - points[i, 2]
    return math.sqrt(x * x + y * y + z * z)


@device
def apart(points, i, others, j, k):
    """Square of the distance from point i to the segment between j and k of ``others``."""
    ex = np.float64(others[k, 0]) - others[j, 0]
    ey = np.float64(others[k, 1]) - others[j, 1]
    ez = np.float64(others[k, 2]) - others[j, 2]
    x = np.float64(points[i, 0]) - others[j, 0]
    y = np.float64(points[i, 1]) - others[j, 1]
    z = np.float64(points[i, 2]) - others[j, 2]
    square = ex * ex + ey * ey + ez * ez
    t = min(max((x * ex + y * ey + z * ez) / square, 0.0), 1.0) if square > 0.0 else 0.0
    x -= t * ex
    y -= t * ey
    z -= t * ez
    return x * x + y * y + z * z
