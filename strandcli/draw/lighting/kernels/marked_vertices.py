"""Vertices of strands that are to be shaded."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined


@device
def longest(first, begin, end):
    """Return the number of vertices of the longest of the strands begin … end − 1."""
    most = np.int64(0)
    for s in range(begin, end):
        most = max(most, first[s + 1] - first[s])
    return most


@inlined
def find_marked(marks, begin, end, marked):
    """Write the marked vertices from begin … end − 1 to ``marked``, without branches; return how many they are."""
    n = np.uint64(0)
    for v in range(begin, end):
        marked[n] = v
        n += np.uint64(marks[v] != 0)
    return n
