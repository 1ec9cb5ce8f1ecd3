"""Which strands are at fault."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .bounded import rows_not_finite
from .edit.subsample import GOLDEN, mixed
from .strands import CHUNK, Mask, Strands


def not_finite(strands: Strands) -> Mask:
    """Strands (S,) of which a point is NaN or infinite."""
    rows = rows_not_finite(strands.points)
    found = np.zeros(strands.count, np.bool_)
    found[np.searchsorted(strands.first, rows, side="right") - 1] = True
    return found


def without_length(strands: Strands) -> Mask:
    """Strands (S,) whose points are all in one place."""
    return strands.lengths() == 0


def repeated(strands: Strands) -> Mask:
    """Strands (S,) that have the points of an earlier one, in every bit."""
    found = np.zeros(strands.count, np.bool_)
    keys = fingerprints(strands)
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    first, points = strands.first, strands.points.view(np.uint32)
    for place in same:
        one, other = order[place], order[place + 1]
        a, b = points[first[one] : first[one + 1]], points[first[other] : first[other + 1]]
        found[other] = a.shape == b.shape and bool((a == b).all())
    return found


def fingerprints(strands: Strands) -> npt.NDArray[np.uint64]:
    """A number of the bits of each strand (S,): equal strands have equal ones, others hardly ever."""
    found = np.zeros(strands.count, np.uint64)
    first = strands.first
    step = max(1, CHUNK // max(1, int(strands.points.shape[0] / max(1, strands.count))))
    with np.errstate(over="ignore"):
        for begin in range(0, strands.count, step):
            end = min(begin + step, strands.count)
            low, high = int(first[begin]), int(first[end])
            place = np.arange(low, high) - np.repeat(first[begin:end], np.diff(first[begin : end + 1]))
            factor = mixed(place.astype(np.uint64) * np.uint64(GOLDEN) + np.uint64(1)) | np.uint64(1)
            bits = strands.points[low:high].view(np.uint32).astype(np.uint64)
            whole = bits[:, 0] + bits[:, 1] * np.uint64(GOLDEN) + bits[:, 2] * mixed(np.array([GOLDEN], np.uint64))
            found[begin:end] = np.add.reduceat(mixed(whole) * factor, first[begin:end] - low)
    return found
