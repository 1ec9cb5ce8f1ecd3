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
def shares(points, rows, out):
    """out (S, m) float32: how far along strands (S, n, 3) their points ``rows`` (S, m) are, as shares of the length."""
    for s in prange(out.shape[0]):
        travel(points[s], rows[s], out[s])


@device
def travel(points, rows, out):
    """`shares` of one strand; of one without length by number."""
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
        share = way / whole if whole > 0.0 else rows[k] / last
        out[k] = np.float32(min(share, 1.0))
