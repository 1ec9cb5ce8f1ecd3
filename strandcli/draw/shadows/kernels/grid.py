"""Strands as a light sees them, listed in the square cells of a grid that they touch, nearest first.

A piece of a strand is a flat band there. Its key is the depth number, complemented so that nearer is smaller, above the
index of the piece's first vertex.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, inlined, parallel, prange

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
BEHIND = np.float32(1 - 2e-6)
"""What is as far away as a line, but for rounding, does not shade it."""
LOW = np.int64(0xFFFFFFFF)
NEAREST = np.int64(0x7FFFFFFF)
"""No less than the bits of any number that is not negative."""
SHIFT = np.int64(32)
# Rows of numbers, one for each band of a cell: how far aside a point of the cell lies; how far along, in lengths; half
# the width and the depth number at the band's beginning, and how much each grows to its end, evenly.
ASIDE_X, ASIDE_Y, ASIDE, ALONG_X, ALONG_Y, ALONG, WIDTH, WIDENS, DEPTH, GROWS = range(10)
ROWS = 10


@parallel
def list_bands(first, bands, stretch, members, begin, size, rows, workers, at, keys):
    """List in every cell the bands that touch it: how many there are, where `keys` is None, or else their keys.

    first (S + 1,) int64; bands (V, 4): of each vertex x and y in cells, the depth number of `project.points`, half the
    width in cells, which lines aside of the view's middle exceed up to `stretch` times; members, begin, rows, workers:
    as in `minmax.fill`; at (size * size,) int64: counts, to be added to, or the place of each cell's next key; keys
    (K,) int64.
    """
    for task in prange(workers):
        for b in range(task, begin.shape[0] - 1, workers):
            top = b * rows
            bottom = min(top + rows, size)
            for m in range(begin[b], begin[b + 1]):
                s = members[m]
                for v in range(first[s], first[s + 1] - 1):
                    if bands[v, 2] > ZERO and bands[v + 1, 2] > ZERO:
                        list_one(bands, v, stretch, top, bottom, size, at, keys)


@device
def list_one(bands, v, stretch, top, bottom, size, at, keys):
    """All that `list_bands` does with the piece after vertex v in the rows from `top` to before `bottom`."""
    x0 = bands[v, 0]
    y0 = bands[v, 1]
    x1 = bands[v + 1, 0]
    y1 = bands[v + 1, 1]
    half = stretch * max(bands[v, 3], bands[v + 1, 3])
    key = nearness(max(bands[v, 2], bands[v + 1, 2])) | v
    for row in range(whole(min(y0, y1) - half, top, bottom), whole(max(y0, y1) + half + ONE, top, bottom)):
        low, high = columns(x0, y0, x1, y1, half, row)
        for column in range(whole(low, 0, size), whole(high + ONE, 0, size)):
            cell = row * size + column
            if keys is not None:
                keys[at[cell]] = key
            at[cell] += 1


@inlined
def nearness(q):
    """The upper half of a key."""
    return (NEAREST - np.int64(np.float32(q).view(np.int32))) << SHIFT


@inlined
def whole(x, low, high):
    """The greatest whole number that is no greater than x, kept between two others."""
    return np.int64(min(max(math.floor(x), np.float32(low)), np.float32(high)))


@inlined
def columns(x0, y0, x1, y1, half, row):
    """From where to where a band reaches in a row of cells, or somewhat further."""
    begin = ZERO
    end = ONE
    rise = y1 - y0
    if rise != ZERO:
        a = (np.float32(row) - half - y0) / rise
        b = (np.float32(row) + ONE + half - y0) / rise
        begin = max(begin, min(a, b))
        end = min(end, max(a, b))
    a = x0 + begin * (x1 - x0)
    b = x0 + end * (x1 - x0)
    return min(a, b) - half, max(a, b) + half


@parallel
def equations(first, bands, focal, middle, out):
    """Of the piece after each vertex the numbers (V, 10) named above; of a strand's last vertex, those of no band.

    focal: cells that a metre is wide at a depth of one; 0 for an orthographic view; middle: of the view, in cells. A
    cylinder whose axis is seen at an angle β from the middle is 1 / cos β times wider on the plane of the view.
    """
    for s in prange(first.shape[0] - 1):
        for v in range(first[s], first[s + 1]):
            last = v + 1 == first[s + 1]
            gx = ZERO if last else bands[v + 1, 0] - bands[v, 0]
            gy = ZERO if last else bands[v + 1, 1] - bands[v, 1]
            square = gx * gx + gy * gy
            seen = square > TINY
            per = ONE / math.sqrt(square) if seen else ZERO
            out[v, ASIDE_X] = -gy * per
            out[v, ASIDE_Y] = gx * per
            out[v, ASIDE] = (gy * bands[v, 0] - gx * bands[v, 1]) * per
            past = (out[v, ASIDE] + (out[v, ASIDE_X] + out[v, ASIDE_Y]) * middle) / focal if focal > ZERO else ZERO
            wider = math.sqrt(ONE + past * past)
            per *= per
            out[v, ALONG_X] = gx * per
            out[v, ALONG_Y] = gy * per
            out[v, ALONG] = -(gx * bands[v, 0] + gy * bands[v, 1]) * per
            out[v, WIDTH] = bands[v, 3] * wider if seen else -ONE
            out[v, WIDENS] = (bands[v + 1, 3] - bands[v, 3]) * wider if seen else ZERO
            out[v, DEPTH] = bands[v, 2] * BEHIND
            out[v, GROWS] = ZERO if last else (bands[v + 1, 2] - bands[v, 2]) * BEHIND


@parallel
def order(begin, size, table, keys, lines):
    """Sort the keys of each cell, and write down their bands as rows of numbers, for places relative to its corner.

    begin (size * size + 1,) int64: where each cell's keys begin in keys, and a tenth of where its rows do in lines
    (10 K,) float32; table (V, 10): of `equations`.
    """
    for row in prange(size):
        for column in range(size):
            cell = np.int64(row) * size + column
            i = begin[cell]
            n = begin[cell + 1] - i
            if n > 1:
                keys[i : i + n].sort()
            x = np.float32(column)
            y = np.float32(row)
            for k in range(n):
                v = keys[i + k] & LOW
                at = ROWS * i + k
                for r in range(ROWS):
                    lines[at + r * n] = table[v, r]
                lines[at + ASIDE * n] += table[v, ASIDE_X] * x + table[v, ASIDE_Y] * y
                lines[at + ALONG * n] += table[v, ALONG_X] * x + table[v, ALONG_Y] * y
