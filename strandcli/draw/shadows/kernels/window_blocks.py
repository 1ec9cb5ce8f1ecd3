"""Cells of filter windows in which strands can be before a point, found for a vector of neighbouring points at once.

Neighbours have nearly the same windows. A load compares as many cells beside each other as a vector has lanes with the
farthest of the points, where gathering the cells of each takes that many loads. Where windows read every second cell,
every fourth and so on, squares of as many cells are looked at, whose nearest depths are known
(`strandcli.draw.shadows.fronts`). What is left out adds nothing to any of the points.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ....jit import inlined
from ....simd import floor, lane_count, load, movemask, reduce_max, where
from ...common.kernels.numbers import HALF

FAR = np.float32(1e6)
NO_BITS, ALL_BITS = np.uint64(0), np.uint64(0xFFFFFFFFFFFFFFFF)
MOST = 64
"""Squares beside each other that are looked at, one bit each; where windows lie farther apart, all count as shaded."""


class WindowBlocks(NamedTuple):
    """What the windows of a vector of points have in common. Columns and rows are of cells."""

    bits: Any
    """Squares are 2^bits cells wide."""
    begin: Any
    """Index of the first square of a map's."""
    size: Any
    """Squares along a side of the map."""
    deepest: Any
    """The greatest depth of a point, metres, float32."""
    left: Any
    right: Any
    top: Any
    bottom: Any
    """Least and greatest first column and row of a window, int64."""
    step: Any
    leap: Any
    """Least and greatest distance between columns or rows that are read, int64."""
    first: Any
    """First column of squares that is looked at."""
    count: Any
    """Number of these columns."""


@inlined
def blocks_about(windows, wide, used, d, deep):
    """Return the `WindowBlocks` of `filter_window.windows_about`; wide: their columns; used: mask of the points that
    have a window; d: depths of the points; deep: `filter_window.DeepMap`."""
    column, row = floor(HALF * windows.left), floor(HALF * windows.top)
    left, right = least(column, used), greatest(column, used)
    step, leap = least(windows.jump, used), greatest(windows.jump, used)
    bits = np.int64(0)
    begin, size = deep.front, deep.size >> 1
    while np.int64(1) << bits < leap:
        begin += size * size
        size = (size + 1) >> 1
        bits += 1
    first = max(left, 0) >> bits
    last = min((right + (wide - 1) * leap) >> bits, size - 1)
    return WindowBlocks(
        bits, begin, size, reduce_max(where(used, d, -FAR)), left, right, least(row, used), greatest(row, used),
        step, leap, first, last - first + 1,
    )  # fmt: skip


@inlined
def least(x, used):
    """Return the least of whole numbers where a mask is set, int64."""
    return -np.int64(reduce_max(where(used, -x, -FAR)))


@inlined
def greatest(x, used):
    """Return the greatest of whole numbers where a mask is set, int64."""
    return np.int64(reduce_max(where(used, x, -FAR)))


@inlined
def shaded_columns(blocks, row, deep):
    """Return bits of the columns of squares, from the first on, in which strands can be before one of the points, for
    the row of cells with a number, counted from each window's first."""
    if blocks.count > MOST:
        return ALL_BITS
    found = NO_BITS
    top = max(blocks.top + row * blocks.step, 0) >> blocks.bits
    bottom = min((blocks.bottom + row * blocks.leap) >> blocks.bits, blocks.size - 1)
    for y in range(top, bottom + 1):
        at = blocks.begin + y * blocks.size + blocks.first
        for x in range(0, blocks.count, lane_count(deep.fronts)):
            found |= np.uint64(movemask(load(deep.fronts, at + x) < blocks.deepest)) << np.uint64(x)
    return found


@inlined
def is_shaded(blocks, found, column):
    """Return whether strands can be before one of the points in a column of cells, counted from each window's first;
    found: from `shaded_columns`."""
    if blocks.count > MOST:
        return True
    low = max(((blocks.left + column * blocks.step) >> blocks.bits) - blocks.first, 0)
    high = min(((blocks.right + column * blocks.leap) >> blocks.bits) - blocks.first, MOST - 1)
    if high < low:
        return False
    mine = (ALL_BITS << np.uint64(low)) & (ALL_BITS >> np.uint64(MOST - 1 - high))
    return (found & mine) != NO_BITS
