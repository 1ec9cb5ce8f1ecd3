"""Which strands are at fault."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .bounded import rows_not_finite
from .edit.subsample import GOLDEN, mixed
from .strands import CHUNK, Mask, Offsets, Strands


def not_finite(strands: Strands) -> Mask:
    """Strands (S,) of which a point is NaN or infinite."""
    rows = rows_not_finite(strands.points)
    found = np.zeros(strands.count, np.bool_)
    found[np.searchsorted(strands.first, rows, side="right") - 1] = True
    return found


def without_length(strands: Strands) -> Mask:
    """Strands (S,) whose points are all in one place."""
    found: Mask = (strands.roots() == strands.tips()).all(axis=1)
    if found.any():  # the others have a length for sure
        found[found] = strands.select(found).lengths() == 0
    return found


def repeated(strands: Strands) -> Mask:
    """Strands (S,) that have the points of an earlier one, in every bit."""
    found = np.zeros(strands.count, np.bool_)
    keys, counts = fingerprints(strands), strands.counts()
    order = np.argsort(keys, kind="stable")
    one, other = order[:-1], order[1:]
    like = (keys[one] == keys[other]) & (counts[one] == counts[other])
    one, other = one[like], other[like]
    ends = np.cumsum(counts[one])
    begin = 0
    while begin < one.size:  # some pairs at once
        done = int(ends[begin - 1]) if begin else 0
        stop = max(begin + 1, int(np.searchsorted(ends, done + CHUNK, side="right")))
        found[other[begin:stop]] = _equal(strands, one[begin:stop], other[begin:stop])
        begin = stop
    return found


def _equal(strands: Strands, one: Offsets, other: Offsets) -> Mask:
    """Whether strands have the same bits, pair by pair of as many points."""
    counts = strands.counts()[one]
    begins = np.cumsum(counts) - counts
    place = np.arange(int(counts.sum())) - np.repeat(begins, counts)
    bits = strands.points.view(np.uint32)
    same = np.ones(place.shape[0], np.bool_)
    for axis in range(3):
        column = bits[:, axis]
        rows = [place + np.repeat(strands.first[side], counts) for side in (one, other)]
        same &= column[rows[0]] == column[rows[1]]
    return np.logical_and.reduceat(same, begins)


def fingerprints(strands: Strands) -> npt.NDArray[np.uint64]:
    """A number of the bits of each strand (S,): equal strands have equal ones, others hardly ever."""
    found = np.zeros(strands.count, np.uint64)
    first, total = strands.first, strands.points.shape[0]
    third = mixed(np.array([GOLDEN], np.uint64))
    with np.errstate(over="ignore"):
        for begin in range(0, total, CHUNK):  # which cuts strands in parts
            end = min(begin + CHUNK, total)
            low = int(np.searchsorted(first, begin, side="right")) - 1
            high = int(np.searchsorted(first, end, side="left"))
            begins = np.maximum(first[low:high], begin)
            lasts = np.minimum(first[low + 1 : high + 1], end)
            place = np.arange(begin, end) - np.repeat(first[low:high], lasts - begins)
            factor = mixed(place.astype(np.uint64) * np.uint64(GOLDEN) + np.uint64(1)) | np.uint64(1)
            bits = strands.points[begin:end].view(np.uint32).astype(np.uint64)
            whole = bits[:, 0] + bits[:, 1] * np.uint64(GOLDEN) + bits[:, 2] * third
            found[low:high] += np.add.reduceat(mixed(whole + np.uint64(GOLDEN)) * factor, begins - begin)
    return found
