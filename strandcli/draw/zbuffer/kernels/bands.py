"""Bands of screen rows, and lists of the strands that overlap each."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import function
from ...common.kernels.numbers import ZERO


class Bands(NamedTuple):
    """Lists of strands by the band of screen rows that they overlap."""

    begin: NDArray[np.int64]
    """(bands + 1,) first index in `members` of each band's list."""
    members: NDArray[np.int32]
    """(M,) strands, band by band, ascending in each."""
    rows: int
    """Height of a band."""
    workers: int
    """Tasks that share the bands."""


@function
def find(first, screen, height, rows, margin, out):
    """Find the bands that each strand overlaps.

    first (S + 1,) int64 vertex offsets; screen (V, 3) float32, as in `ScreenLines`; height: of the screen, pixels;
    rows: height of a band; margin: half the greatest width of a line, pixels; out (S, 2) int32: first and last band,
    first > last for a strand that is not on the screen.
    """
    last_band = (height - 1) // rows
    for s in range(first.shape[0] - 1):
        low = np.float32(np.inf)
        high = np.float32(-np.inf)
        for v in range(first[s], first[s + 1]):
            if screen[v, 2] > ZERO:
                low = min(low, screen[v, 1])
                high = max(high, screen[v, 1])
        if low <= high and high + margin >= ZERO and low - margin < np.float32(height):
            out[s, 0] = int(max(low - margin, ZERO)) // rows
            out[s, 1] = min(int(min(high + margin, np.float32(height))) // rows, last_band)
        else:
            out[s, 0] = 1
            out[s, 1] = 0


@function
def count(ranges, out):
    """Write the first index of each band's list to out (bands + 1,) int64; ranges (S, 2): from `find`."""
    out[:] = 0
    for s in range(ranges.shape[0]):
        for b in range(ranges[s, 0], ranges[s, 1] + 1):
            out[b + 1] += 1
    for b in range(1, out.shape[0]):
        out[b] += out[b - 1]


@function
def scatter(ranges, cursor, members):
    """List the strands band by band, in ascending order. cursor (bands,) int64: first index of each list, changed;
    members (M,) int32 out."""
    for s in range(ranges.shape[0]):
        for b in range(ranges[s, 0], ranges[s, 1] + 1):
            members[cursor[b]] = s
            cursor[b] += 1
