"""Which points of strands are drawn, and how far along the strand each is."""

from __future__ import annotations

import numpy as np

from ...exchange.kernels.along import distance
from ...jit import device, parallel, prange


@parallel
def choose(keep, counts, rows):
    """Rows (S, m) int32 of the points to draw of strands (S, n): those that ``keep`` (S, n) marks, so many each
    (S,), and of the others as many as are wanting, evenly chosen."""
    for s in prange(rows.shape[0]):
        fill(keep[s], counts[s], rows[s])


@device
def fill(keep, count, rows):
    """`choose` of one strand."""
    rest = keep.shape[0] - count
    wanting = rows.shape[0] - count
    k = 0
    seen = 0
    for i in range(keep.shape[0]):
        taken = keep[i]
        if not taken:
            taken = (seen + 1) * wanting // rest > seen * wanting // rest
            seen += 1
        if taken:
            rows[k] = i
            k += 1


@parallel
def write(points, rows, out):
    """out (S, m, 4) float32: the points ``rows`` (S, m) of strands (S, n, 3), and how far along the strand each is, as
    a share of its length."""
    for s in prange(out.shape[0]):
        travel(points[s], rows[s], out[s])


@device
def travel(points, rows, out):
    """`write` of one strand; of one without length by number."""
    last = points.shape[0] - 1
    whole = 0.0
    for i in range(last):
        whole += distance(points, i, i + 1)
    way = 0.0
    i = 0
    for k in range(rows.shape[0]):
        while i < rows[k]:
            way += distance(points, i, i + 1)
            i += 1
        for c in range(3):
            out[k, c] = points[i, c]
        out[k, 3] = np.float32(min(way / whole if whole > 0.0 else i / last, 1.0))
