"""Vertices of a batch that a light reaches past solids: only these need maps, lobes and tables."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, inlined
from ...common.kernels.batch import ARRIVES, COLOUR, EX, EXTRA, LX, RADIANCE, REACH, TX, X
from ...common.kernels.numbers import ZERO

THREES = (X, TX, EX, COLOUR, EXTRA, RADIANCE, LX)
"""The first of three rows each that hold what is known of a vertex and the current light."""


@device
def lit_first(work, n, which):
    """Reorder the first n vertices of a batch so that those where light arrives come first; return how many they are.

    work: rows of `batch`, those before `REACH` and the light's own; which (n,): numbers of the vertices, reordered too.
    """
    k = np.int64(0)
    end = n
    while True:
        while k < end and work[ARRIVES + k] > ZERO:
            k += 1
        while k < end and not work[ARRIVES + end - 1] > ZERO:
            end -= 1
        if k >= end:
            return k
        end -= 1
        which[k], which[end] = which[end], which[k]
        for first in THREES:
            for row in range(first, first + 3 * W, W):
                work[row + k], work[row + end] = work[row + end], work[row + k]
        for row in (REACH, ARRIVES):
            work[row + k], work[row + end] = work[row + end], work[row + k]
        k += 1


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
