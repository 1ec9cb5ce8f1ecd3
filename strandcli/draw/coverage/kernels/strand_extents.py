"""Bounds on the rows and the number of pixels that strands cover, before their fragments are found."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, parallel, prange
from ...common.kernels.numbers import HALF, ONE, ZERO
from .segments import POINT, is_ribbon

RISE = np.float32(1.5)
"""Rows across that a cell of a strand of no width touches, on average over all slopes, about: one more where it crosses
a border of rows, half the time."""
MARGIN = np.float32(2.0)
"""Pixels that a strand extends beyond its vertices, besides its width."""
LEAST_Y, GREATEST_Y, WIDEST = 0, 1, 2
"""Columns of the extents of strands."""
COLUMNS = 3


@parallel
def find_extents(first, screen, widths, width, out):
    """Write the range of y that each strand can cover, and its greatest width.

    first (S + 1,) int64; screen (V, 3): as in `ScreenLines`; widths (V,): likewise, or (0,): all are one pixel; width:
    of the picture; out (S, COLUMNS) float32: least and greatest y, inf and −inf for a strand that is not on the
    screen; the width.
    """
    for s in prange(first.shape[0] - 1):
        low = np.float32(np.inf)
        high = np.float32(-np.inf)
        left = np.float32(np.inf)
        right = np.float32(-np.inf)
        widest = ONE if widths.shape[0] == 0 else ZERO
        for v in range(first[s], first[s + 1]):
            if widths.shape[0] > 0:
                widest = max(widest, widths[v])
            if screen[v, 2] > ZERO:
                left = min(left, screen[v, 0])
                right = max(right, screen[v, 0])
                low = min(low, screen[v, 1])
                high = max(high, screen[v, 1])
        margin = MARGIN + widest  # a mitre extends by up to half a width times the square root of two
        there = (right + margin >= ZERO) & (left - margin < np.float32(width))
        out[s, LEAST_Y] = low - margin if there else np.float32(np.inf)
        out[s, GREATEST_Y] = high + margin if there else np.float32(-np.inf)
        out[s, WIDEST] = widest


@parallel
def count_wide_pixels(lines, extents, width, height, broad, out):
    """Write an estimate of the pixels that are visited for the segments of each strand that are wider than `broad`.

    For each it is the length of its bounding box along its longer screen axis, times the height across of its band, or
    of the picture if that is less. lines: `ScreenLines` with widths; extents: from `find_extents`; width, height: of
    the picture; broad: float32; out (S,) float32.
    """
    first, screen, widths = lines
    for s in prange(first.shape[0] - 1):
        total = ZERO
        for v in range(first[s] + 1, first[s + 1] if extents[s, WIDEST] > broad else 0):
            w = max(widths[v - 1], widths[v])
            dx = abs(screen[v, 0] - screen[v - 1, 0])
            dy = abs(screen[v, 1] - screen[v - 1, 1])
            if w > broad and max(dx, dy) >= POINT and screen[v - 1, 2] > ZERO and screen[v, 2] > ZERO:
                size = np.float32(math.sqrt(dx * dx + dy * dy))
                across = inside(screen[v - 1, 0], screen[v, 0], HALF * w * dy / size, np.float32(width))
                down = inside(screen[v - 1, 1], screen[v, 1], HALF * w * dx / size, np.float32(height))
                total += min(across, w * size / dy) * down if dx < dy else across * min(down, w * size / dx)
        out[s] = total


@parallel
def estimate_rows(lines, width, changes):
    """Add about how many fragments each row of a picture has to changes (tasks, height + 1) float64, as differences
    from row to row; each task has a share of the strands. lines: `ScreenLines`; width: of the picture."""
    tasks = changes.shape[0]
    strands = lines.first.shape[0] - 1
    for one in prange(tasks):
        task = np.int64(one)
        for s in range(task * strands // tasks, (task + 1) * strands // tasks):
            estimate_strand(lines.screen, lines.widths, lines.first[s], lines.first[s + 1], width, changes[task])


@device
def estimate_strand(screen, widths, begin, end, width, changes):
    """`estimate_rows` of the strand of the vertices begin … end − 1; changes (height + 1,)."""
    wide, tall = np.float32(width), np.float32(changes.shape[0] - 1)
    for v in range(begin + 1, end):
        x0, y0, x1, y1 = screen[v - 1, 0], screen[v - 1, 1], screen[v, 0], screen[v, 1]
        across = inside(x0, x1, ZERO, wide)
        down = inside(y0, y1, ZERO, tall)
        low = min(y0, y1)
        w = ONE if widths is None else HALF * (widths[v - 1] + widths[v])
        beside = max(x0, x1) < -HALF * w or min(x0, x1) > wide + HALF * w
        if screen[v - 1, 2] > ZERO and screen[v, 2] > ZERO and across + down > ZERO and low < tall and not beside:
            cells = max(across, down)
            each = cells * (w + RISE)
            dx, dy = x1 - x0, y1 - y0
            # a ribbon has fragments of its own wherever it touches a pixel
            if widths is not None and is_ribbon(dx, dy, np.sqrt(dx * dx + dy * dy), w):
                each = (cells + ONE) * (w + ONE)
            each = min(each, wide * tall)  # a segment has one fragment a pixel
            top = np.int64(max(low, ZERO))
            rows = min(np.int64(down) + 1, changes.shape[0] - 1 - top)
            changes[top] += each / np.float32(rows)
            changes[top + rows] -= each / np.float32(rows)


@device
def inside(one, other, reach, end):
    """Return the length of the interval between two coordinates, extended by `reach` at both ends and clipped to
    0 … end."""
    return max(min(max(one, other) + reach, end) - max(min(one, other) - reach, ZERO), ZERO)
