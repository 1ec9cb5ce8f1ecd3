"""Sphere tracing of a batch of rays: `smooth_union.meet`, vectorised over rays.

Finished rays are removed whenever they are a quarter of the rest, so that the few rays that graze a surface do not keep
the others busy. A solid counts for all rays or for none; far from a ray it has no influence on it.
"""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, function, inlined
from ....solids.shapes import capsule, sphere
from ...common.kernels.approximations import exp, log
from . import smooth_union

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
INF = np.float32(np.inf)
TOGETHER = np.int64(8)
"""Rays of a vector."""

# Rows of numbers, one a ray: origin, direction, result; then for active rays: number, origin and direction, current
# position and end of the search in units of |d|, 1 / |d|, distance of the nearest solid there, sum of weights, result.
OX, OY, OZ, DX, DY, DZ, MET = (i * W for i in range(7))
WHICH, X, Y, Z, WX, WY, WZ, T, END, PER = (i * W for i in range(7, 17))
LEAST, TOTAL, FOUND = (i * W for i in range(17, 20))
ROWS = 20
MOVED = 10
"""Rows from `WHICH` on that are moved when rays are compacted."""


@function
def meet(work, n, spheres, capsules):
    """Store where the first n <= W rays of a batch meet the surface, in units of |d|, inf where they miss.

    Reads the rows `OX` … `DZ` and writes `MET`. work (ROWS * W,) float32; all rows must be initialised."""
    k = smooth_union.blend_distance(spheres, capsules)
    reach = smooth_union.APART * k
    per_k = ONE / k
    felt = begin(work, n, spheres, capsules, k)
    count = compact(work, n)
    step = 0
    while count > 0 and step < smooth_union.STEPS:
        padded = (count + TOGETHER - 1) // TOGETHER * TOGETHER
        for j in range(padded):
            work[LEAST + j] = INF
            work[TOTAL + j] = ZERO
        for m in range(spheres.shape[0]):
            if (felt >> np.uint64(m & 63)) & np.uint64(1) != np.uint64(0) and smooth_union.blends(spheres, capsules, m):
                x, y, z = spheres[m, sphere.X], spheres[m, sphere.Y], spheres[m, sphere.Z]
                by_sphere(work, padded, x, y, z, spheres[m, sphere.RADIUS], reach, per_k)
        for own in range(capsules.shape[0]):
            m = own + spheres.shape[0]
            if (felt >> np.uint64(m & 63)) & np.uint64(1) != np.uint64(0) and smooth_union.blends(spheres, capsules, m):
                by_capsule(work, padded, capsules, own, reach, per_k)
        step += 1
        left = advance(work, padded, k, HALF if step == smooth_union.STEPS else smooth_union.NEAR, step == 1)
        if 4 * left <= 3 * count or step == smooth_union.STEPS:
            count = compact(work, count)


@device
def begin(work, n, spheres, capsules, k):
    """Initialise all rays, and limit their search to the bounding balls; return the bit mask of solids that count."""
    for j in range(n):
        dx, dy, dz = work[DX + j], work[DY + j], work[DZ + j]
        work[WHICH + j] = np.float32(j)
        work[X + j] = work[OX + j]
        work[Y + j] = work[OY + j]
        work[Z + j] = work[OZ + j]
        work[WX + j] = dx
        work[WY + j] = dy
        work[WZ + j] = dz
        work[T + j] = INF
        work[END + j] = ZERO
        work[PER + j] = ONE / math.sqrt(dx * dx + dy * dy + dz * dz)
        work[FOUND + j] = INF
    felt = np.uint64(0)
    for m in range(spheres.shape[0] + capsules.shape[0]):
        if smooth_union.blends(spheres, capsules, m):
            cx, cy, cz, r = smooth_union.ball_about(spheres, capsules, m)
            if extend_search(work, n, cx, cy, cz, r + smooth_union.APART * k) > 0:
                felt |= np.uint64(1) << np.uint64(m & 63)
    return felt


@device
def extend_search(work, n, cx, cy, cz, r):
    """Extend the search interval of each ray by its chord in a ball; return how many rays cross the ball."""
    square = r * r
    hits = np.int32(0)
    for j in range(n):
        t, half = smooth_union.through(
            cx - work[X + j], cy - work[Y + j], cz - work[Z + j], square, work[WX + j], work[WY + j], work[WZ + j]
        )
        hit = (half >= ZERO) & (t + half > ZERO)
        low, high = work[T + j], work[END + j]
        work[T + j] = min(low, max(t - half, ZERO)) if hit else low
        work[END + j] = max(high, t + half) if hit else high
        hits += np.int32(hit)
    return hits


@device
def compact(work, count):
    """Store the results of all active rays, and keep only the unfinished ones; return their number."""
    left = np.int64(0)
    for j in range(count):
        work[MET + np.int64(work[WHICH + j])] = work[FOUND + j]
        on = (work[FOUND + j] == INF) & (work[T + j] <= work[END + j])
        for row in range(MOVED):
            work[WHICH + row * W + left] = work[WHICH + row * W + j]
        left += np.int64(on)
    for j in range(left, min(left + TOGETHER, W)):
        work[END + j] = -INF
    return left


@device
def by_sphere(work, n, cx, cy, cz, r, reach, per_k):
    """Add a sphere to the sums at the current positions of the rays."""
    for j in range(n):
        t = work[T + j]
        x = work[X + j] + t * work[WX + j] - cx
        y = work[Y + j] + t * work[WY + j] - cy
        z = work[Z + j] + t * work[WZ + j] - cz
        add(work, j, math.sqrt(x * x + y * y + z * z) - r, reach, per_k)


@device
def by_capsule(work, n, capsules, m, reach, per_k):
    """Add a capsule to the sums at the current positions of the rays."""
    ax, ay, az = capsules[m, capsule.X], capsules[m, capsule.Y], capsules[m, capsule.Z]
    bx, by, bz = capsules[m, capsule.AXIS_X], capsules[m, capsule.AXIS_Y], capsules[m, capsule.AXIS_Z]
    r, per = capsules[m, capsule.RADIUS], capsules[m, capsule.PER_SQUARE]
    for j in range(n):
        t = work[T + j]
        x = work[X + j] + t * work[WX + j] - ax
        y = work[Y + j] + t * work[WY + j] - ay
        z = work[Z + j] + t * work[WZ + j] - az
        s = min(max((x * bx + y * by + z * bz) * per, ZERO), ONE)
        x -= s * bx
        y -= s * by
        z -= s * bz
        add(work, j, math.sqrt(x * x + y * y + z * z) - r, reach, per_k)


@inlined
def add(work, j, away, reach, per):
    """Add a solid at the distance `away` to the sums of ray j. Weights are relative to the nearest solid, which has 1;
    a solid farther than `reach` behind it has none."""
    least, total = work[LEAST + j], work[TOTAL + j]
    apart = abs(away - least)
    share = exp(-apart * per) if apart <= reach else ZERO
    work[TOTAL + j] = total * share + ONE if away < least else total + share
    work[LEAST + j] = min(least, away)


@device
def advance(work, n, k, near, first):
    """Advance each ray by its distance from the surface, or finish it where that is less than `near` k; return the
    number of unfinished rays. first: whether this is the first step."""
    left = np.int64(0)
    near *= k
    for j in range(n):
        away = work[LEAST + j] - k * log(work[TOTAL + j])
        t, end = work[T + j], work[END + j]
        end = -INF if first & (away < ZERO) else end  # a ray that begins inside misses by definition
        met = (away < near) & (t <= end)
        t = t if met else t + away * work[PER + j]
        work[FOUND + j] = t if met else INF
        work[T + j] = t
        work[END + j] = end
        left += np.int64((away >= near) & (t <= end))
    return left
