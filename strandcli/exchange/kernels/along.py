"""Points along strands, by arc length; and those that they can do without (Douglas and Peucker, 1973).

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
    total = length(points, begin, end)
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
    return off(points, begin, end, out[s], total)


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
def length(points, begin, end):
    """Of the polyline from point ``begin`` to ``end``."""
    total = 0.0
    for i in range(begin, end):
        total += distance(points, i, i + 1)
    return total


@device
def apart(points, i, line, j, k):
    """Square of the distance from point i to the segment between j and k of ``line``."""
    ex = np.float64(line[k, 0]) - line[j, 0]
    ey = np.float64(line[k, 1]) - line[j, 1]
    ez = np.float64(line[k, 2]) - line[j, 2]
    x = np.float64(points[i, 0]) - line[j, 0]
    y = np.float64(points[i, 1]) - line[j, 1]
    z = np.float64(points[i, 2]) - line[j, 2]
    square = ex * ex + ey * ey + ez * ez
    t = min(max((x * ex + y * ey + z * ez) / square, 0.0), 1.0) if square > 0.0 else 0.0
    x -= t * ex
    y -= t * ey
    z -= t * ez
    return x * x + y * y + z * z


@device
def off(points, begin, end, out, total):
    """Greatest distance of points ``begin`` to ``end`` of a strand, which is ``total`` long, from the segments of
    ``out`` (n, 3) that stand for them: each for as much of its length."""
    last = out.shape[0] - 1
    worst = 0.0
    passed = 0.0
    for i in range(begin, end + 1):
        if i > begin:
            passed += distance(points, i - 1, i)
        k = min(int(passed / total * last), last - 1) if total > 0.0 else 0
        worst = max(worst, apart(points, i, out, k, k + 1))
    return math.sqrt(worst)


PIECE = 1024
"""Every so many points one stays: what the method costs grows with the square of a piece."""
BEGIN, END = 0, 1
"""Columns of a span: its first and its last point."""


@parallel
def simplify(first, points, widths, tolerance, keep, deviation):
    """Which points stay, so that every other one is within ``tolerance`` of the segment between those about it, and
    the strand's edge of where it would be: first (S + 1,) int64 of points (P, 3) with widths (P,), or None where they
    do not matter; keep (P,) bool, all false, and deviation (S,) float64 are written."""
    for s in prange(deviation.shape[0]):
        waiting = np.empty((PIECE, 2), np.int64)
        worst = 0.0
        begin = first[s]
        end = first[s + 1] - 1
        keep[begin] = True
        while begin < end:
            stop = min(begin + PIECE, end)
            keep[stop] = True
            worst = max(worst, thin(points, widths, begin, stop, tolerance * tolerance, keep, waiting))
            begin = stop
        deviation[s] = math.sqrt(worst)


@device
def thin(points, widths, begin, stop, square, keep, waiting):
    """Mark the points between two that must stay; returns the largest squared distance of one that goes. ``waiting``
    (n, 2) int64: scratch for the spans that are not looked at yet, at most as many as points."""
    worst = 0.0
    count = 0
    waiting[count, BEGIN] = begin
    waiting[count, END] = stop
    count = 1
    while count > 0:
        count -= 1
        low = waiting[count, BEGIN]
        high = waiting[count, END]
        far = 0.0
        place = low
        for i in range(low + 1, high):
            d = apart(points, i, points, low, high)
            if widths is not None:
                d += narrower(points, widths, i, low, high)
            if d > far:
                far = d
                place = i
        if far > square:
            keep[place] = True
            waiting[count, BEGIN] = low
            waiting[count, END] = place
            waiting[count + 1, BEGIN] = place
            waiting[count + 1, END] = high
            count += 2
        else:
            worst = max(worst, far)
    return worst


@device
def narrower(points, widths, i, low, high):
    """Square of the distance between the edges of a strand at point i and of one whose width changes evenly from point
    ``low`` to ``high``."""
    before, after = distance(points, low, i), distance(points, i, high)
    t = before / (before + after) if before + after > 0.0 else 0.0
    off = 0.5 * (widths[i] - (widths[low] + t * (widths[high] - widths[low])))
    return off * off
