"""Pairs of segments whose boxes meet, by a uniform grid whose cells are kept in a hash table (Teschner et al. 2003).

A box lies in every cell that it touches. Cells that share a bucket are told apart by their numbers, and a pair counts
in one cell alone: that of the lower corner of what both boxes have in common.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, function
from .contact_columns import AXES, FIRST, FIRST_SEGMENT, HIGH, LOW, SECOND, SECOND_SEGMENT

PRIMES = np.array([73856093, 19349663, 83492791])


@device
def cell_at(box, corner, axis, side):
    """Number of the cell of a box's corner along an axis."""
    return math.floor(box[corner + axis] / side)


@device
def bucket_of(x, y, z, buckets):
    """Bucket of a cell; ``buckets`` is a power of 2."""
    return (np.int64(x) * PRIMES[0] ^ np.int64(y) * PRIMES[1] ^ np.int64(z) * PRIMES[2]) & (buckets - 1)


@function
def fill_cells(boxes, side, starts, entries, cells):
    """Set the boxes of each bucket in their order, ``entries`` (m,), and the cells that they are there for, ``cells``
    (m, 3). ``starts`` (buckets + 2,) int64: from its second on, where each bucket begins; these are moved on to where
    it ends. Without entries, add to it from its third on how many boxes lie in the cells of each bucket."""
    buckets = len(starts) - 2
    for i in range(len(boxes)):
        box = boxes[i]
        for x in range(cell_at(box, LOW, 0, side), cell_at(box, HIGH, 0, side) + 1):
            for y in range(cell_at(box, LOW, 1, side), cell_at(box, HIGH, 1, side) + 1):
                for z in range(cell_at(box, LOW, 2, side), cell_at(box, HIGH, 2, side) + 1):
                    bucket = bucket_of(x, y, z, buckets) + 1
                    if entries is None:
                        starts[bucket + 1] += 1
                        continue
                    at = starts[bucket]
                    starts[bucket] = at + 1
                    entries[at] = i
                    cells[at, 0], cells[at, 1], cells[at, 2] = x, y, z


@device
def meet_here(one, other, cell, side):
    """Whether two boxes meet, and the lower corner of what they have in common lies in a cell."""
    for axis in range(AXES):
        low = max(one[LOW + axis], other[LOW + axis])
        if low > min(one[HIGH + axis], other[HIGH + axis]) or math.floor(low / side) != cell[axis]:
            return False
    return True


@function
def find_pairs(boxes, segments, apart, side, table, pairs):
    """Set ``pairs`` (m, 4) int64 while there is room, and return how many there are. ``segments``: of a strand; those
    of one strand count where they are further ``apart`` than so many segments. ``table``: starts, entries and cells
    that `fill_cells` has set."""
    starts, entries, cells = table
    count = 0
    for bucket in range(len(starts) - 2):
        for k in range(starts[bucket], starts[bucket + 1]):
            i = entries[k]
            for m in range(k + 1, starts[bucket + 1]):
                j = entries[m]
                if cells[m, 0] != cells[k, 0] or cells[m, 1] != cells[k, 1] or cells[m, 2] != cells[k, 2]:
                    continue
                if i // segments == j // segments and abs(i - j) <= apart:
                    continue
                if not meet_here(boxes[i], boxes[j], cells[k], side):
                    continue
                if count < len(pairs):
                    pairs[count, FIRST], pairs[count, FIRST_SEGMENT] = i // segments, i % segments
                    pairs[count, SECOND], pairs[count, SECOND_SEGMENT] = j // segments, j % segments
                count += 1
    return count
