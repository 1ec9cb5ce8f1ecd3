"""Points of strands in rows: packed in blocks; which of them are drawn, and how far along the strand each is."""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...exchange.kernels.along import distance
from ...jit import device, parallel, prange


@parallel
def place(first, points, most, per, out):
    """Write to out (P,) the rows that points of strands get where all have ``most``, over ``per``; of a strand that has
    more of them, the shares of its length before them. First (S + 1,) int64 of points (P, 3)."""
    for s in prange(first.shape[0] - 1):
        place_strand(points, first[s], first[s + 1], most, per, out)


@device
def place_strand(points, begin, end, most, per, out):
    """`place` of the strand of the points from ``begin`` to ``end``; one without length has its points by number."""
    last = end - begin - 1
    whole = 0.0
    for i in range(begin, end - 1):
        whole += distance(points, i, i + 1)
    way = 0.0
    for i in range(last + 1):
        if i > 0:
            way += distance(points, begin + i - 1, begin + i)
        share = way / whole if 0.0 < whole < np.inf else i / last
        out[begin + i] = share if last >= most else (i + np.rint(share * (most - last - 1))) / per


@parallel
def pack(first, points, rows, order, out):
    """Write strands in an ``order`` (S,) to blocks out (blocks, n + 1, 3 W), as `groom.blocks` has them; first
    (S + 1,) of points (P, 3), of which each strand has n, or which get the rows (P,)."""
    for block in prange(out.shape[0]):
        b = np.int64(block)
        for lane in range(W):
            s = order[min(b * W + lane, order.shape[0] - 1)]
            for c in range(3):
                lay(points, rows, first[s], first[s + 1], c, out[b, 1:, c * W + lane])
        for k in range(3 * W):
            out[b, 0, k] = np.float32(2.0) * out[b, 1, k] - out[b, 2, k]


@parallel
def spread(first, values, rows, order, out):
    """Write values (P, 1) of the points of strands in an ``order`` (S,), which get the rows (P,), to out (S, n)."""
    for s in prange(out.shape[0]):
        lay(values, rows, first[order[s]], first[order[s] + 1], 0, out[s])


@device
def lay(values, rows, begin, end, c, out):
    """Write column c of the values from ``begin`` to ``end`` to out (n,): in their rows, and linear ones between."""
    if rows is None:
        for i in range(begin, end):
            out[i - begin] = values[i, c]
        return
    for i in range(begin, end - 1):
        low, high = np.int64(rows[i]), np.int64(rows[i + 1])
        a, b = np.float64(values[i, c]), np.float64(values[i + 1, c])
        out[low] = values[i, c]
        for k in range(low + 1, high):
            out[k] = a + (k - low) / (high - low) * (b - a)
    out[np.int64(rows[end - 1])] = values[end - 1, c]


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
