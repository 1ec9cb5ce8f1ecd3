"""How much of a picture strands can touch, before their fragments are found."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, parallel, prange
from .segments import POINT, WIDE

ZERO = np.float32(0.0)
HALF = np.float32(0.5)


@parallel
def spans(first, screen, margin, width, out):
    """The rows of the screen that each strand can touch.

    first (S + 1,) int64; screen (V, 3); margin: how far it reaches beyond its vertices, pixels; width of the screen;
    out (S, 2) float32: least and greatest y, inf and −inf for a strand that is not there.
    """
    for s in prange(first.shape[0] - 1):
        low = np.float32(np.inf)
        high = np.float32(-np.inf)
        left = np.float32(np.inf)
        right = np.float32(-np.inf)
        for v in range(first[s], first[s + 1]):
            if screen[v, 2] > ZERO:
                left = min(left, screen[v, 0])
                right = max(right, screen[v, 0])
                low = min(low, screen[v, 1])
                high = max(high, screen[v, 1])
        there = (right + margin >= ZERO) & (left - margin < np.float32(width))
        out[s, 0] = low - margin if there else np.float32(np.inf)
        out[s, 1] = high + margin if there else np.float32(-np.inf)


@parallel
def count_wide_pixels(lines, width, height, out):
    """About how many pixels of a picture have to be visited for the wide segments of each strand: the cells that a
    segment's box has along the axis that it follows more, times the rows that its band has across or the picture.

    lines: `ScreenLines` with widths; out (S,) float32.
    """
    first, screen, widths = lines
    for s in prange(first.shape[0] - 1):
        total = ZERO
        for v in range(first[s] + 1, first[s + 1]):
            w = max(widths[v - 1], widths[v])
            dx = abs(screen[v, 0] - screen[v - 1, 0])
            dy = abs(screen[v, 1] - screen[v - 1, 1])
            if w > WIDE and max(dx, dy) >= POINT and screen[v - 1, 2] > ZERO and screen[v, 2] > ZERO:
                size = np.float32(math.sqrt(dx * dx + dy * dy))
                across = inside(screen[v - 1, 0], screen[v, 0], HALF * w * dy / size, np.float32(width))
                down = inside(screen[v - 1, 1], screen[v, 1], HALF * w * dx / size, np.float32(height))
                total += min(across, w * size / dy) * down if dx < dy else across * min(down, w * size / dx)
        out[s] = total


@device
def inside(one, other, reach, end):
    """How much of the way between two places, and a reach beyond both, lies between 0 and an end."""
    return max(min(max(one, other) + reach, end) - max(min(one, other) - reach, ZERO), ZERO)
