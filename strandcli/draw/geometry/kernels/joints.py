"""Mitred joints of wide segments: both end on one line, so that a bend shows neither gap nor overlap."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)


@device
def mitre(screen, v, a, end, dx, dy, half, per):
    """Return the unit normal of the joint between a segment of direction d = (dx, dy) and its neighbour, from vertex v
    to v + 1 of the strand a … end − 1: halfway between their directions.

    It is d itself at a strand's end, and where a mitre does not fit: the strand turns by more than a right angle, or so
    much that the joint's line would extend beyond the other end of one of the segments. screen: as in `ScreenLines`;
    half: half the width at the joint, pixels; per: one over the length of the segment.
    """
    if v < a or v + 1 >= end or screen[v, 2] <= ZERO or screen[v + 1, 2] <= ZERO:
        return dx, dy
    ex = screen[v + 1, 0] - screen[v, 0]
    ey = screen[v + 1, 1] - screen[v, 1]
    size = ONE / math.sqrt(max(ex * ex + ey * ey, TINY))
    cosine = (ex * dx + ey * dy) * size
    # tan² of half the angle; both segments get the same result
    tangent = (ONE - cosine) / max(ONE + cosine, TINY)
    squat = half * max(size, per)
    if cosine <= ZERO or tangent * squat * squat > ONE:
        return dx, dy
    mx = ex * size + dx
    my = ey * size + dy
    size = ONE / math.sqrt(mx * mx + my * my)
    return mx * size, my * size
