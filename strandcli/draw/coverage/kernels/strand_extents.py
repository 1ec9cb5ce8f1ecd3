"""Bounds on the rows and the number of pixels that strands cover, before their fragments are found."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, parallel, prange
from .segments import POINT, WIDE

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
LEAST_Y, GREATEST_Y = 0, 1
"""Columns of the extents of strands."""


@parallel
def find_extents(first, screen, margin, width, out):
    """Write the range of y that each strand can cover.

    first (S + 1,) int64; screen (V, 3): as in `ScreenLines`; margin: greatest distance that a strand extends beyond its
    vertices, pixels; width: of the picture; out (S, 2) float32: least and greatest y; inf and −inf for a strand that is
    not on the screen.
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
        out[s, LEAST_Y] = low - margin if there else np.float32(np.inf)
        out[s, GREATEST_Y] = high + margin if there else np.float32(-np.inf)


@parallel
def count_wide_pixels(lines, width, height, out):
    """Write an estimate of the pixels that are visited for the wide segments of each strand.

    For each segment it is the length of its bounding box along its longer screen axis, times the height across of its
    band, or of the picture if that is less. lines: `ScreenLines` with widths; width, height: of the picture; out (S,)
    float32.
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
    """Return the length of the interval between two coordinates, extended by `reach` at both ends and clipped to
    0 … end."""
    return max(min(max(one, other) + reach, end) - max(min(one, other) - reach, ZERO), ZERO)
