"""Points that strands can do without (Douglas and Peucker, 1973)."""

from __future__ import annotations

import math

import numpy as np

from ...jit import device, parallel, prange
from .along import apart, distance

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
        mark(keep, begin)
        while begin < end:
            stop = min(begin + PIECE, end)
            mark(keep, stop)
            worst = max(worst, thin(points, widths, begin, stop, tolerance * tolerance, keep, waiting))
            begin = stop
        deviation[s] = math.sqrt(worst)


@device
def mark(keep, i):
    """Point i stays."""
    keep[i] = True


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
            mark(keep, place)
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
