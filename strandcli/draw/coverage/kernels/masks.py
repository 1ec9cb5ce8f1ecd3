"""Which part of a sample each of several wide strands shows: the A-buffer's masks (Carpenter 1984).

A sample has 64 points, a bit each, laid out so that an edge of any direction leaves about as many of them on one side
as it leaves area there. What a band covers is what lies between the two lines along it and the two across its ends;
the points on one side of a line come from a table over its direction and its distance from the sample's middle.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, inlined

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
POINTS = 64
EMPTY, WHOLE = np.uint64(0), np.uint64(0xFFFFFFFFFFFFFFFF)
WAYS = 128
"""Directions of lines in half a turn, and"""
DISTANCES = 64
"""distances from the middle, from `-REACH` to `REACH` samples."""
REACH = np.float32(0.72)
_PER = np.float32(DISTANCES / (2 * REACH))
_ROW = np.int64(DISTANCES + 1)
_FROM = np.float32(REACH * _PER + 0.5)


@inlined
def table_row(x, y):
    """Where the table has lines with the normal (x, y), y >= 0, of length 1: by 1 − x / (|x| + |y|)."""
    return np.int64((ONE - x / (abs(x) + abs(y))) * np.float32(WAYS / 2) + HALF) * _ROW


@inlined
def points_behind(table, row, turn, distance):
    """The points p with p · n < distance, as bits; turn: −1 where −n is the normal in the row of the table, else 1."""
    k = np.int64(min(max(distance * turn * _PER + _FROM, ZERO), np.float32(DISTANCES)))
    bits = table[np.uint64(row + k)]
    return bits if turn > ZERO else ~bits


@device
def covered(table, screen, widths, v, x, y):
    """Of the piece from vertex v to the next, in the sample whose middle is (x, y): the points it covers."""
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
        bits &= points_behind(table, row, turn, size - past) & ~points_behind(table, row, turn, -past)
    return bits
