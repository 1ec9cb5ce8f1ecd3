"""Which strands are at fault, and which things are equal, found by fingerprints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from .strands import Mask, Strands

AT_ONCE = 1 << 14
"""Things that are compared at once."""
GOLDEN = 0x9E3779B97F4A7C15
Keys = npt.NDArray[np.uint64]
Numbers = npt.NDArray[np.int64]


def mixed(z: Keys) -> Keys:
    """The bits of numbers mixed up, the last step of SplitMix64 (Steele et al., 2014); numbers overflow on purpose."""
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


def prints_of(words: Keys) -> Keys:
    """A number for each row of words (n, k): equal rows have equal ones, others hardly ever."""
    found = np.zeros(words.shape[0], np.uint64)
    with np.errstate(over="ignore"):
        for column in range(words.shape[1]):
            found = mixed(found + words[:, column] + np.uint64(GOLDEN))
    return found


def repeats(prints: Keys, equal: Callable[[Numbers, Numbers], Mask]) -> tuple[Numbers, Numbers]:
    """Things that are equal to one of a lower number: the lowest such of each, and their own. ``prints`` (n,): their
    fingerprints; ``equal``: whether things with some numbers are equal to others."""
    order = np.argsort(prints, kind="stable")
    own = prints[order]
    again = np.flatnonzero(own[1:] == own[:-1]) + 1
    del own
    new = np.diff(again, prepend=-1) != 1
    one, other = order[again[new] - 1][np.cumsum(new) - 1], order[again]
    parts = [slice(begin, begin + AT_ONCE) for begin in range(0, one.size, AT_ONCE)]
    same = np.concatenate([np.zeros(0, np.bool_), *(equal(one[part], other[part]) for part in parts)])
    return one[same], other[same]


def not_finite(strands: Strands) -> Mask:
    """Strands (S,) of which a point is NaN or infinite."""
    return np.logical_or.reduceat(~np.isfinite(strands.points).all(axis=1), strands.first[:-1])


def without_length(strands: Strands) -> Mask:
    """Strands (S,) whose points are all in one place."""
    found: Mask = (strands.roots() == strands.tips()).all(axis=1)
    if found.any():  # the rest have a length for sure
        found[found] = strands.select(found).lengths() == 0
    return found


def repeated(strands: Strands) -> Mask:
    """Strands (S,) that have the points of an earlier one, in every bit."""

    def bits(number: int) -> bytes:
        return strands.points[strands.first[number] : strands.first[number + 1]].tobytes()

    def equal(one: Numbers, other: Numbers) -> Mask:
        return np.array([bits(a) == bits(b) for a, b in zip(one.tolist(), other.tolist(), strict=True)], np.bool_)

    found = np.zeros(strands.count, np.bool_)
    prints = np.fromiter((hash(bits(number)) for number in range(strands.count)), np.int64, strands.count)
    found[repeats(prints.view(np.uint64), equal)[1]] = True
    return found
