"""Directions and joints of the wide segments of a strand, several at once: those of `geometry.kernels.joints.mitre`."""

from __future__ import annotations

import numpy as np

from ....jit import inlined
from ....simd import deinterleave, half_width_pointer, lane_count, load, sqrt, store, where
from ...common.kernels.numbers import HALF, ONE, STEPS, ZERO
from .segments import JOINED, ROW, WIDTH

TINY = np.float32(1e-30)
# Rows of the vertices from the one before those loaded on: position on the screen and depth number; then those of
# segments, as in `segments`: unit direction, one over the length on the screen, and the normals of the joints at both
# ends.
X, Y, DEPTH, DX, DY, PER_LENGTH, MX0, MY0, MX1, MY1 = (JOINED + i * ROW for i in range(10))


@inlined
def measure_joints(points, base, count, begin, end, work):
    """Store the rows from `DX` on of the segments that `segments.measure_segments` has measured.

    points: half-width pointer to (V, 3); base: last vertex of the first of the `count` segments, of the strand of the
    vertices begin … end − 1; work: that of `segments`.
    """
    rows, numbers = half_width_pointer(work), half_width_pointer(STEPS)
    first = max(base - 2, begin)
    deinterleave(points, 3 * first, min(base + count + 1, end) - first, work, X + first - (base - 2), ROW)
    before, after = np.float32(begin - base + 2), np.float32(end - base - 1)
    for k in range(0, count, lane_count(rows)):
        x0, y0, x1, y1 = load(rows, X + k + 1), load(rows, Y + k + 1), load(rows, X + k + 2), load(rows, Y + k + 2)
        there0, there1 = load(rows, DEPTH + k + 1) > ZERO, load(rows, DEPTH + k + 2) > ZERO
        number = load(numbers, k)
        there0 = there0 & (load(rows, DEPTH + k) > ZERO) & ~(number < before)
        there1 = there1 & (load(rows, DEPTH + k + 3) > ZERO) & (number < after)
        dx, dy = x1 - x0, y1 - y0
        per = ONE / sqrt(dx * dx + dy * dy)
        dx, dy = dx * per, dy * per
        half0, half1 = HALF * load(rows, WIDTH + k), HALF * load(rows, WIDTH + k + 1)
        mx0, my0 = joint(x0 - load(rows, X + k), y0 - load(rows, Y + k), dx, dy, half0, per, there0)
        mx1, my1 = joint(load(rows, X + k + 3) - x1, load(rows, Y + k + 3) - y1, dx, dy, half1, per, there1)
        k += 1
        store(rows, DX + k, dx)
        store(rows, DY + k, dy)
        store(rows, PER_LENGTH + k, per)
        store(rows, MX0 + k, mx0)
        store(rows, MY0 + k, my0)
        store(rows, MX1 + k, mx1)
        store(rows, MY1 + k, my1)


@inlined
def joint(ex, ey, dx, dy, half, per, there):
    """Return `mitre` of segments of direction (dx, dy) and their neighbours, which extend by (ex, ey); there: whether
    they have one in front of the eye. Vectors."""
    size = ONE / sqrt(max(ex * ex + ey * ey, TINY))
    cosine = (ex * dx + ey * dy) * size
    tangent = (ONE - cosine) / max(ONE + cosine, TINY)
    squat = half * max(size, per)
    fits = there & ~((cosine <= ZERO) | (tangent * squat * squat > ONE))
    mx = ex * size + dx
    my = ey * size + dy
    size = ONE / sqrt(mx * mx + my * my)
    return where(fits, mx * size, dx), where(fits, my * size, dy)
