"""Sorting of a tile's fragments by pixel and depth."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ....simd import broadcast, lane_count, load, pointer, store, where
from ...common.kernels.numbers import ONE, ZERO
from .tiles import AT_DEPTH, AT_VERTEX, NUMBERS

RUN = 128
"""Greatest length of a list that is sorted by counting; longer lists are merged from runs of this length."""
FOUR = np.uint64(NUMBERS)


@device
def sort_pixels(fragments, counts, ends, depths, ranks, spare, order):
    """Write the indices of listed fragments to `order`, each pixel's sorted by depth, nearest first, ties by vertex.

    fragments, counts, ends, depths: `listed` and the rest of `crowds.list_by_pixel`; ranks (RUN,) float32, spare:
    scratch.

    The rank of a fragment is the number of nearer ones. To count them takes more comparisons than other methods, but
    no branch that has to be predicted, and is vector code. Long lists are sorted in runs of `RUN` that are merged.
    """
    for p in range(counts.shape[0]):
        n = np.int64(counts[p])
        first = np.int64(ends[p]) - n
        for low in range(first, first + n, RUN):
            size = min(first + n - low, RUN)
            count_nearer(pointer(depths), pointer(ranks), low, size)
            total = np.int64(0)
            for i in range(np.uint64(size)):
                o = np.int64(ranks[i])
                total += o
                order[np.uint64(low + o)] = np.uint32(np.uint64(low) + i)
            if total != size * (size - 1) // 2:  # equal depths have the same rank
                insertion_sort(fragments, low, size, order)
        if n > RUN:
            merge_runs(fragments, first, n, order, spare)


@inlined
def count_nearer(rows, ranks, low, size):
    """Store the rank of each of `size` depths from index `low` on: the number of nearer ones."""
    for first in range(0, size, lane_count(rows)):
        own = load(rows, low + first)
        nearer = broadcast(rows, ZERO)
        for j in range(low, low + size):
            nearer = where(own < rows[j], nearer + ONE, nearer)
        store(ranks, first, nearer)


@device
def precedes(fragments, i, j):
    """Return whether fragment i comes before fragment j."""
    one = np.int32(fragments[np.uint64(i) * FOUR + AT_DEPTH]).view(np.float32)
    other = np.int32(fragments[np.uint64(j) * FOUR + AT_DEPTH]).view(np.float32)
    tie = fragments[np.uint64(i) * FOUR + AT_VERTEX] < fragments[np.uint64(j) * FOUR + AT_VERTEX]
    return (one > other) | ((one == other) & tie)


@device
def insertion_sort(fragments, first, n, order):
    """Sort the list of n fragments from index `first` on by insertion."""
    for i in range(first, first + n):
        new = np.uint32(i)
        j = i
        while j > first and precedes(fragments, new, order[j - 1]):
            order[j] = order[j - 1]
            j -= 1
        order[j] = new


@device
def merge_runs(fragments, first, n, order, spare):
    """Merge the sorted runs of `RUN` of the list of n fragments from index `first` on."""
    size = RUN
    while size < n:
        for low in range(first, first + n, 2 * size):
            middle = min(low + size, first + n)
            high = min(middle + size, first + n)
            i = low
            j = middle
            for o in range(low, high):
                left = i < middle and (j >= high or precedes(fragments, order[i], order[j]))
                spare[o - first] = order[i] if left else order[j]
                i += np.int64(left)
                j += np.int64(not left)
        for o in range(n):
            order[first + o] = spare[o]
        size *= 2
