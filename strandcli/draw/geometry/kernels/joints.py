"""Where pieces of wide strands meet: both end on one line, so that a bend shows neither gap nor notch."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)


@device
def mitre(screen, v, a, end, dx, dy, half, per):
    """Normal of the joint between a piece of direction d and its neighbour, the one from vertex v to v + 1: halfway
    between their directions. At a strand's end it is d itself, and where the strand turns by more than a right angle,
    or by so much that the joint's line, half the width long, would leave one of the two pieces at its other end.

    half: of the width at the joint; per: one over the piece's length.
    """
    if v < a or v + 1 >= end or screen[v, 2] <= ZERO or screen[v + 1, 2] <= ZERO:
        return dx, dy
    ex = screen[v + 1, 0] - screen[v, 0]
    ey = screen[v + 1, 1] - screen[v, 1]
    size = ONE / math.sqrt(max(ex * ex + ey * ey, TINY))
    cosine = (ex * dx + ey * dy) * size
    # tan² of half the angle; both pieces come to the same answer
    tangent = (ONE - cosine) / max(ONE + cosine, TINY)
    squat = half * max(size, per)
    if cosine <= ZERO or tangent * squat * squat > ONE:
        return dx, dy
    mx = ex * size + dx
    my = ey * size + dy
    size = ONE / math.sqrt(mx * mx + my * my)
    return mx * size, my * size
