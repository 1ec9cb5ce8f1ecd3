"""What strands have in a band of rows of a picture."""

from __future__ import annotations

import numpy as np

from ....jit import parallel, prange
from ...common.kernels.numbers import ONE, ZERO

BESIDE = 2
"""Vertices of a strand before a band and behind it: those at its border have the light, the widths and the joints that
their neighbours give them."""
REACH = np.float32(0.75)
"""Widths that a strand extends beside its axis: a mitre by half of one times the square root of two."""
STRANDS = 256
"""Strands a task."""


@parallel
def find(first, screen, widths, top, bottom, begin, counts):
    """Write the first of the vertices that each strand has in the rows top <= y < bottom, and how many they are, with
    `BESIDE` more before and behind them: begin, counts (S,) int64 out.

    A strand loses an even number of its first vertices, because light that counts little is that at vertices of even
    rank. first, screen, widths: of `ribbon.ScreenLines`.
    """
    strands = first.shape[0] - 1
    for task in prange((strands + STRANDS - 1) // STRANDS):
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            low, high = first[s + 1], first[s] - 1  # of the vertices about segments that come to the rows
            for v in range(first[s], first[s + 1] - 1):
                y0, y1 = screen[v, 1], screen[v + 1, 1]
                margin = ONE + REACH * (ONE if widths is None else max(widths[v], widths[v + 1]))
                seen = screen[v, 2] > ZERO and screen[v + 1, 2] > ZERO
                if seen and min(y0, y1) - margin < bottom and max(y0, y1) + margin >= top:
                    low, high = min(low, v), v + 1
            begin[s] = max(low - BESIDE, first[s])
            begin[s] -= (begin[s] - first[s]) % 2
            counts[s] = max(min(high + BESIDE + 1, first[s + 1]) - begin[s], 0) if high >= low else 0


@parallel
def copy(begin, first, column, out):
    """Copy the rows of vertices from column (V, C) to out (K, C): those from begin (S,) on of each strand to first[s] …
    first[s + 1] − 1."""
    strands = begin.shape[0]
    for task in prange((strands + STRANDS - 1) // STRANDS):
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            for v in range(first[s], first[s + 1]):
                for c in range(column.shape[1]):
                    out[v, c] = column[begin[s] + v - first[s], c]
