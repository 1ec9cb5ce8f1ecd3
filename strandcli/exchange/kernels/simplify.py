"""Points that strands can do without (Douglas and Peucker, 1973)."""

from __future__ import annotations

import math

import numpy as np

from ...jit import device, parallel, prange
from .along import apart

PIECE = 1024
"""Every so many points one stays: what the method costs grows with the square of a piece."""
BEGIN, END = 0, 1
"""Columns of a span: its first and its last point."""


@parallel
def simplify(first, points, tolerance, keep, deviation):
    """Which points stay, so that every other one is within ``tolerance`` of the segment between those about it:
    first (S + 1,) int64 of points (P, 3); keep (P,) bool, all false, and deviation (S,) float64 are written."""
    for s in prange(deviation.shape[0]):
        waiting = np.empty((PIECE, 2), np.int64)
        worst = 0.0
        begin = first[s]
        end = first[s + 1] - 1
        mark(keep, begin)
        while begin < end:
            stop = min(begin + PIECE, end)
            mark(keep, stop)
            worst = max(worst, thin(points, begin, stop, tolerance * tolerance, keep, waiting))
            begin = stop
        deviation[s] = math.sqrt(worst)


@device
def mark(keep, i):
    """Point i stays."""
    keep[i] = True


@device
def thin(points, begin, stop, square, keep, waiting):
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
