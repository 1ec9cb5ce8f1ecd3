"""Widths at the vertices of polylines, from those at the points that curves pass through."""

from __future__ import annotations

import numpy as np

from ....jit import parallel, prange
from ...common.kernels.numbers import ONE

STRANDS = 256
"""Strands a task."""


@parallel
def find(first, along, shares, out):
    """Write the share of its strand's width that each vertex has, out (V,) float32.

    first (S + 1,) int64: first vertex of each strand; along (V,): how far along its strand each vertex stands, 0 to 1,
    or None: evenly; shares (S, n) float32: at its n points, which stand evenly, linear between them.
    """
    strands = first.shape[0] - 1
    last = np.int64(shares.shape[1] - 1)
    for task in prange((strands + STRANDS - 1) // STRANDS):
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            begin = first[s]
            per = ONE / np.float32(max(first[s + 1] - begin - 1, 1))
            for v in range(begin, first[s + 1]):
                place = np.float32(v - begin) * per if along is None else along[v]
                at = place * np.float32(last)
                i = min(np.int64(at), last - 1)
                t = min(at - np.float32(i), ONE)
                out[v] = (ONE - t) * shares[s, i] + t * shares[s, i + 1]
