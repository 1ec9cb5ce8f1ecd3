"""A tile's fragments listed by pixel and sorted by depth."""

from __future__ import annotations

import numpy as np

from ....constants import VECTOR
from ....jit import device, inlined
from ....simd import broadcast, count_true, half_width_pointer, lane_count, load, pointer, store, where
from .tiles import NUMBERS, PIXELS

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
RUN = 128
"""Lists no longer than this are sorted by counting."""
FEW_LANES = VECTOR // 2 // 4
"""Fragments that are a vector of a `half_width_pointer`, which most lists are,"""
MORE_LANES = VECTOR // 4
"""or one of a `pointer`."""
STEPS = np.arange(MORE_LANES, dtype=np.float32)
IN_PIXEL = np.int32(PIXELS - 1)
ALL = np.uint64(0xFFFFFFFFFFFFFFFF)
ONE_ON, TWO, FOUR = np.uint64(1), np.uint64(2), np.uint64(NUMBERS)


@device
def list_by_pixel(fragments, n, counts, starts, depths, listed):
    """List a tile's n fragments pixel by pixel.

    counts, starts (PIXELS,): length of each pixel's list and, afterwards, where it ends; depths: their depth numbers;
    listed: which they are.
    """
    total = np.int64(0)
    for p in range(PIXELS):
        starts[p] = total
        total += counts[p]
    for i in range(np.uint64(n)):
        p = np.uint64(fragments[i * FOUR + np.uint64(3)] & IN_PIXEL)
        at = np.uint64(starts[p])
        starts[p] += 1
        depths[at] = np.int32(fragments[i * FOUR]).view(np.float32)
        listed[at] = np.uint32(i)


@device
def sort_pixels(fragments, counts, ends, depths, listed, behind, spare, order):
    """Sort each pixel's list, nearest first, ties by index: `order` becomes what `listed` is before;
    behind (RUN,) float32, spare: to work with.

    Each goes behind as many as are nearer: counting them takes more comparisons than other ways, but none that has to
    be guessed, and vector code. Long lists are sorted in runs of `RUN` that are merged.
    """
    for p in range(counts.shape[0]):
        n = np.int64(counts[p])
        first = np.int64(ends[p]) - n
        if n <= FEW_LANES:
            rows, steps = half_width_pointer(depths), load(half_width_pointer(STEPS), 0)
            if sort_few(rows, steps, first, n, FEW_LANES, listed, order):
                insertion_sort(fragments, listed, first, n, order)
            continue
        if n <= MORE_LANES:
            wide_rows, wide_steps = pointer(depths), load(pointer(STEPS), 0)
            if sort_few(wide_rows, wide_steps, first, n, MORE_LANES, listed, order):
                insertion_sort(fragments, listed, first, n, order)
            continue
        for low in range(first, first + n, RUN):
            size = min(first + n - low, RUN)
            count_nearer(pointer(depths), pointer(behind), low, size)
            total = np.int64(0)
            for i in range(np.uint64(size)):
                o = np.int64(behind[i])
                total += o
                order[np.uint64(low + o)] = listed[np.uint64(low) + i]
            if total != size * (size - 1) // 2:  # some are equally far, and have one place together
                insertion_sort(fragments, listed, low, size, order)
        if n > RUN:
            merge_runs(fragments, first, n, order, spare)


@inlined
def sort_few(rows, steps, low, n, lanes, listed, order):
    """Sort n that are no more than a vector from place `low` on, and tell whether some are equally far. As many steps
    for a few as for all: when a short loop ends has to be guessed. What is no part of the list goes behind it, where
    the next one comes."""
    own = load(rows, low)
    there = steps < np.float32(n)
    taken = np.uint64(0)
    for i in range(lanes):
        o = count_true((own > rows[low + i]) & there) if i < n else np.uint64(lanes)
        order[np.uint64(low) + o] = listed[np.uint64(low + i)]
        taken |= ONE_ON << o
    return taken & ~(ALL << np.uint64(n)) != ~(ALL << np.uint64(n))


@inlined
def count_nearer(rows, ranks, low, size):
    """How many of so many depths from place `low` on are nearer than each."""
    for some in range(0, size, lane_count(rows)):
        own = load(rows, low + some)
        nearer = broadcast(rows, ZERO)
        for j in range(low, low + size):
            nearer = where(own < rows[j], nearer + ONE, nearer)
        store(ranks, some, nearer)


@device
def precedes(fragments, i, j):
    """Whether a fragment comes before another."""
    one = np.int32(fragments[np.uint64(i) * FOUR]).view(np.float32)
    other = np.int32(fragments[np.uint64(j) * FOUR]).view(np.float32)
    tie = fragments[np.uint64(i) * FOUR + TWO] < fragments[np.uint64(j) * FOUR + TWO]
    return (one > other) | ((one == other) & tie)


@device
def insertion_sort(fragments, listed, first, n, order):
    """Sort a list of n from place `first` on, one after the other."""
    for i in range(first, first + n):
        new = listed[i]
        j = i
        while j > first and precedes(fragments, new, order[j - 1]):
            order[j] = order[j - 1]
            j -= 1
        order[j] = new


@device
def merge_runs(fragments, first, n, order, spare):
    """Sort a list of n from place `first` on, runs of `RUN` of which are."""
    size = RUN
    while size < n:
        for low in range(first, first + n, 2 * size):
            middle = min(low + size, first + n)
            high = min(middle + size, first + n)
            i = low
            j = middle
            for o in range(low, high):
                take = i < middle and (j >= high or precedes(fragments, order[i], order[j]))
                spare[o - first] = order[i] if take else order[j]
                i += np.int64(take)
                j += np.int64(not take)
        for o in range(n):
            order[first + o] = spare[o]
        size *= 2
