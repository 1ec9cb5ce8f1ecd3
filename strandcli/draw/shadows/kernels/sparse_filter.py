"""Points of a batch at which a shadow filter runs, and interpolation between them.

Neighbouring pixels of a surface are much closer to each other than the texels of an opacity map, so the filtered shadow
changes little from one to the next. Points that follow each other on a straight line across a map form a stretch of up
to `LONGEST` steps. The filter runs at its ends, and at places between where the ends differ or the stretch is longer
than `SPAN` radii of the filter, until neither holds. Elsewhere the result is interpolated by cubics. What the filter
and its search for occluders read at the ends overlaps, so that nothing between the ends is missed by both.
"""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device
from ...common.kernels.batch import DEPTH, INSIDE, U, V
from ...common.kernels.surface_batch import FILTERED, FOUND, LEFT, LIST, NEXT, RADIUS

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
LONGEST = 16
"""Steps of a stretch at the most, a power of two."""
SPAN = np.float32(0.5)
"""Distance between the ends of a stretch, and their difference in depth, in radii of the filter, at the most."""
BENT = np.float32(0.06)
"""Distance of a point of a stretch from its place on the straight line between the ends, in radii, at the most."""
SAME = np.float32(1 / 12)
"""Difference of the ends' transmittance, at the most."""


@device
def list_ends(work, n, texel):
    """Divide the points that are inside of a map into stretches; return how many points are listed.

    Rows: `NEXT` is the number of the point at the end of the stretch that begins at a point, 0 where none begins;
    `LIST` has the numbers of the points to filter. texel: side of a texel, metres, at the map's middle.
    """
    for k in range(W):
        work[NEXT + k] = ZERO
    count = np.int64(0)
    k = np.int64(0)
    listed = False
    while k < n:
        if not work[INSIDE + k] > ZERO:
            k += 1
            listed = False
            continue
        if not listed:
            work[LIST + count] = np.float32(k)
            count += 1
        step = np.int64(LONGEST)
        while step > 1 and (k + step >= n or not is_straight(work, k, step, texel)):
            step >>= 1
        listed = step > 1
        if listed:
            work[NEXT + k] = np.float32(k + step)
            work[LIST + count] = np.float32(k + step)
            count += 1
        k += step
    return count


@device
def is_straight(work, k, step, texel):
    """Return whether the points k to k + step are all inside, and evenly on a short straight line."""
    u, v, d = work[U + k], work[V + k], work[DEPTH + k]
    du, dv, dd = work[U + k + step] - u, work[V + k + step] - v, work[DEPTH + k + step] - d
    radius = min(work[RADIUS + k], work[RADIUS + k + step])
    most = SPAN * radius
    if not (du * du + dv * dv <= most * most and abs(dd) <= most * texel and work[INSIDE + k + step] > ZERO):
        return False
    per = ONE / np.float32(step)
    off = ZERO
    inside = ONE
    for i in range(1, step):
        share = np.float32(i) * per
        off = max(off, abs(work[U + k + i] - u - share * du))
        off = max(off, abs(work[V + k + i] - v - share * dv))
        off = max(off, abs(work[DEPTH + k + i] - d - share * dd) / texel)
        inside = min(inside, work[INSIDE + k + i])
    return off <= BENT * radius and inside > ZERO


@device
def scatter(work, count):
    """Store what was found at the listed points in the rows of all points: `LEFT` and `RADIUS`."""
    for k in range(count):
        at = np.int64(work[LIST + k])
        work[RADIUS + at] = work[FOUND + k]
        for c in range(3):
            work[LEFT + c * W + at] = work[FILTERED + c * W + k]


@device
def list_between(work, n):
    """Divide the stretches whose ends differ in their rows `LEFT`, and those that are long for the radii found at the
    ends, in the rows `RADIUS`; return how many points between the ends are listed."""
    count = np.int64(0)
    for k in range(n):
        end = np.int64(work[NEXT + k])
        step = np.int64(end - k)
        if step > 1:
            excess = max(difference(work, k, end) * (ONE / SAME), relative_length(work, k, end))
            while step > 1 and excess > ONE:
                step >>= 1
                excess *= HALF
            for at in range(k + step, end, step):
                work[NEXT + at] = np.float32(at + step)
                work[LIST + count] = np.float32(at)
                count += 1
            work[NEXT + k] = np.float32(k + step)
    return count


@device
def relative_length(work, k, end):
    """Return the distance of two points in units of `SPAN` times the lesser of their radii."""
    du, dv = work[U + end] - work[U + k], work[V + end] - work[V + k]
    return math.sqrt(du * du + dv * dv) / (SPAN * min(work[RADIUS + k], work[RADIUS + end]))


@device
def difference(work, k, end):
    """Return the greatest difference between two points in red, green and blue of the rows `LEFT`."""
    red = abs(work[LEFT + k] - work[LEFT + end])
    green = abs(work[LEFT + W + k] - work[LEFT + W + end])
    return max(red, max(green, abs(work[LEFT + 2 * W + k] - work[LEFT + 2 * W + end])))


@device
def interpolate(work, n):
    """Interpolate the rows `LEFT` between the ends of all stretches, by cubics whose slopes at an end are those from
    one of its neighbours to the other."""
    begin = np.int64(0)
    before = np.int64(-1)  # the end of the last stretch, which began at `begin`
    for k in range(n):
        end = np.int64(work[NEXT + k])
        if end > k:
            after = np.int64(work[NEXT + end])
            fill(work, begin if before == k else np.int64(k), np.int64(k), end, after if after > end else end)
            begin, before = np.int64(k), end


@device
def fill(work, begin, k, end, after):
    """Interpolate between two points of a batch, with the next to each side or the same."""
    step = np.float32(end - k)
    for c in range(3):
        row = LEFT + c * W
        low, high = work[row + k], work[row + end]
        rise = step * (high - work[row + begin]) / np.float32(end - begin)
        on = step * (work[row + after] - low) / np.float32(after - k)
        for i in range(k + 1, end):
            t = np.float32(i - k) / step
            u = ONE - t
            work[row + i] = low + t * (high - low) + t * u * (u * (rise - high + low) - t * (on - high + low))
