"""Grid over a light's view that lists the strand segments overlapping each square cell, nearest first.

A segment of a strand is a flat band in this view. Its sort key has the complemented depth number, so that nearer is
smaller, in the upper 32 bits, and the index of the segment's first vertex in the lower 32.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, inlined, parallel, prange

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
BEHIND = np.float32(1 - 2e-6)
"""Scales depth numbers of bands, so that rounding does not let a band shade a line at the same depth."""
LOW = np.int64(0xFFFFFFFF)
NEAREST = np.int64(0x7FFFFFFF)
"""Greatest bit pattern of a non-negative float32."""
SHIFT = np.int64(32)
BAND_X, BAND_Y, BAND_DEPTH, HALF_WIDTH = range(4)
"""Columns of the bands at a vertex: x and y in cells, the depth number of `project.points`, half the width in cells."""
# Rows of a cell's table, one entry a band. For a point (x, y) of the cell: signed distance from the band's axis
# ASIDE_X x + ASIDE_Y y + ASIDE, and position along the axis, 0 to 1, ALONG_X x + ALONG_Y y + ALONG. Half width and
# depth number at the band's beginning, and their linear growth to its end.
ASIDE_X, ASIDE_Y, ASIDE, ALONG_X, ALONG_Y, ALONG, WIDTH, WIDENS, DEPTH, GROWS = range(10)
ROWS = 10


@parallel
def list_bands(first, bands, stretch, members, begin, size, rows, workers, at, keys):
    """Count the bands that overlap each cell, if `keys` is None; otherwise store their keys.

    first (S + 1,) int64; bands (V, 4): columns above; perspective widens the half width up to `stretch` times away from
    the view's axis; members, begin, rows, workers: as in `minmax.fill`; at (size * size,) int64: counts that are
    incremented, or the index of each cell's next key; keys (K,) int64.
    """
    for task in prange(workers):
        for b in range(task, begin.shape[0] - 1, workers):
            top = b * rows
            bottom = min(top + rows, size)
            for m in range(begin[b], begin[b + 1]):
                s = members[m]
                for v in range(first[s], first[s + 1] - 1):
                    if bands[v, BAND_DEPTH] > ZERO and bands[v + 1, BAND_DEPTH] > ZERO:
                        list_one(bands, v, stretch, top, bottom, size, at, keys)


@device
def list_one(bands, v, stretch, top, bottom, size, at, keys):
    """Count or list the segment after vertex v in the rows top <= row < bottom; arguments as in `list_bands`."""
    x0 = bands[v, BAND_X]
    y0 = bands[v, BAND_Y]
    x1 = bands[v + 1, BAND_X]
    y1 = bands[v + 1, BAND_Y]
    half = stretch * max(bands[v, HALF_WIDTH], bands[v + 1, HALF_WIDTH])
    key = nearness(max(bands[v, BAND_DEPTH], bands[v + 1, BAND_DEPTH])) | v
    begin = clamped_floor(min(y0, y1) - half, top, bottom)
    for row in range(begin, clamped_floor(max(y0, y1) + half + ONE, top, bottom)):
        low, high = columns(x0, y0, x1, y1, half, row)
        for column in range(clamped_floor(low, 0, size), clamped_floor(high + ONE, 0, size)):
            cell = row * size + column
            if keys is not None:
                keys[at[cell]] = key
            at[cell] += 1


@inlined
def nearness(q):
    """Return the upper half of a key, from the depth number q."""
    return (NEAREST - np.int64(np.float32(q).view(np.int32))) << SHIFT


@inlined
def clamped_floor(x, low, high):
    """Return the floor of x, clamped to low … high."""
    return np.int64(min(max(math.floor(x), np.float32(low)), np.float32(high)))


@inlined
def columns(x0, y0, x1, y1, half, row):
    """Return conservative bounds in x of a band within a row of cells."""
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
    """Write the table (V, ROWS) of the segments after each vertex; a strand's last vertex gets an empty band.

    focal: cells a metre at a depth of one metre, 0 for an orthographic view; middle: centre of the view, in cells. A
    cylinder whose axis appears at an angle β from the view's axis is 1 / cos β times wider on the image plane.
    """
    for s in prange(first.shape[0] - 1):
        for v in range(first[s], first[s + 1]):
            last = v + 1 == first[s + 1]
            gx = ZERO if last else bands[v + 1, BAND_X] - bands[v, BAND_X]
            gy = ZERO if last else bands[v + 1, BAND_Y] - bands[v, BAND_Y]
            square = gx * gx + gy * gy
            seen = square > TINY
            per = ONE / math.sqrt(square) if seen else ZERO
            out[v, ASIDE_X] = -gy * per
            out[v, ASIDE_Y] = gx * per
            out[v, ASIDE] = (gy * bands[v, BAND_X] - gx * bands[v, BAND_Y]) * per
            past = (out[v, ASIDE] + (out[v, ASIDE_X] + out[v, ASIDE_Y]) * middle) / focal if focal > ZERO else ZERO
            wider = math.sqrt(ONE + past * past)
            per *= per
            out[v, ALONG_X] = gx * per
            out[v, ALONG_Y] = gy * per
            out[v, ALONG] = -(gx * bands[v, BAND_X] + gy * bands[v, BAND_Y]) * per
            out[v, WIDTH] = bands[v, HALF_WIDTH] * wider if seen else -ONE
            out[v, WIDENS] = (bands[v + 1, HALF_WIDTH] - bands[v, HALF_WIDTH]) * wider if seen else ZERO
            out[v, DEPTH] = bands[v, BAND_DEPTH] * BEHIND
            out[v, GROWS] = ZERO if last else (bands[v + 1, BAND_DEPTH] - bands[v, BAND_DEPTH]) * BEHIND


@parallel
def order(begin, size, table, keys, lines):
    """Sort the keys of each cell, and write its table in this order, for points relative to the cell's corner.

    begin (size * size + 1,) int64: index of each cell's first key in keys (K,); its table begins at ROWS times that in
    lines (ROWS K,) float32; table (V, ROWS): from `equations`.
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
