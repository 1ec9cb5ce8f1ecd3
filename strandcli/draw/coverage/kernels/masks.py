"""Bit masks of the points of a sample that wide strands cover (A-buffer, Carpenter 1984).

A sample has 64 points, one bit each, placed so that the number of points on one side of an edge is nearly proportional
to the area there, for any direction. A band covers the points between its two edges and between the two lines across
its ends; the points on one side of a line come from a table over its direction and its distance from the sample's
centre.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, inlined
from ...common.kernels.bits import popcount

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
POINTS = 64
NO_POINTS, ALL_POINTS = np.uint64(0), np.uint64(0xFFFFFFFFFFFFFFFF)
DIRECTIONS = 128
"""Directions of the table's lines in half a turn."""
DISTANCES = 64
"""Distances of the table's lines from the sample's centre, from −`REACH` to `REACH` samples."""
REACH = np.float32(0.72)
"""Distance beyond which a line does not cross the sample."""
_PER = np.float32(DISTANCES / (2 * REACH))
_ROW = np.int64(DISTANCES + 1)
_FROM = np.float32(REACH * _PER + 0.5)


@inlined
def table_row(x, y):
    """Return the index of the table's first line with the unit normal (x, y), y >= 0; directions are equidistant in
    1 − x / (|x| + |y|)."""
    return np.int64((ONE - x / (abs(x) + abs(y))) * np.float32(DIRECTIONS / 2) + HALF) * _ROW


@inlined
def points_behind(table, row, turn, distance):
    """Return the mask of the points p with p · n < distance; row: from `table_row`; turn: 1 if n is the normal there,
    −1 if −n is."""
    k = np.int64(min(max(distance * turn * _PER + _FROM, ZERO), np.float32(DISTANCES)))
    bits = table[np.uint64(row + k)]
    return bits if turn > ZERO else ~bits


@device
def covered_points(table, screen, widths, v, x, y, area):
    """Return the mask of the points that the segment after vertex v covers in the sample with the centre (x, y).

    area: of the fragment, in points, if it may be that of several segments in a row, or 0: the mask ends with the
    segment unless without ends its number of points is nearer to the area."""
    x0 = screen[v, 0]
    y0 = screen[v, 1]
    dx = screen[v + 1, 0] - x0
    dy = screen[v + 1, 1] - y0
    square = max(dx * dx + dy * dy, TINY)
    per = ONE / math.sqrt(square)
    size = square * per
    dx *= per
    dy *= per
    past = (x - x0) * dx + (y - y0) * dy
    off = (y - y0) * dx - (x - x0) * dy
    t = min(max(past * per, ZERO), ONE)
    half = HALF * (widths[v] + t * (widths[v + 1] - widths[v]))
    turn = ONE if dx >= ZERO else -ONE
    row = table_row(-dy * turn, dx * turn)
    bits = points_behind(table, row, turn, half - off) & ~points_behind(table, row, turn, -half - off)
    if (past < REACH) | (size - past < REACH):
        turn = ONE if dy >= ZERO else -ONE
        row = table_row(dx * turn, dy * turn)
        cut = bits & points_behind(table, row, turn, size - past) & ~points_behind(table, row, turn, -past)
        if abs(np.float32(popcount(cut)) - area) <= abs(np.float32(popcount(bits)) - area):
            bits = cut
    return bits
