"""Points of strands in rows: packed in blocks; which of them are drawn, and how far along the strand each is."""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...exchange.kernels.along import distance
from ...jit import device, parallel, prange


@parallel
def pack(first, points, order, out):
    """Write strands in an ``order`` (S,) to blocks out (blocks, n + 1, 3 W), as `groom.blocks` has them; first
    (S + 1,) of points (P, 3), of which each strand has n."""
    for block in prange(out.shape[0]):
        begins = np.empty(W, np.int64)
        for k in range(W):
            begins[k] = first[order[min(np.int64(block) * W + k, order.shape[0] - 1)]]
        pack_block(begins, points, out[block])


@device
def pack_block(begins, points, out):
    """`pack` of the block out (n + 1, 3 W) of strands whose first points are ``begins`` (W,)."""
    for i in range(out.shape[0] - 1):
        for k in range(W):
            for c in range(3):
                out[i + 1, c * W + k] = points[begins[k] + i, c]
    for k in range(3 * W):
        out[0, k] = np.float32(2.0) * out[1, k] - out[2, k]


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
