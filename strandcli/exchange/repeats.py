"""Which things are equal, told by fingerprints, in eight bytes of each."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from .strands import Mask

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


def keys_of(prints: Keys, numbers: range, bits: int) -> Keys:
    """The upper bits of fingerprints, and in the lower ``bits`` the numbers of what they are of."""
    return (prints & ~np.uint64((1 << bits) - 1)) | np.arange(numbers.start, numbers.stop, dtype=np.uint64)


def repeats(keys: Keys, bits: int, equal: Callable[[Numbers, Numbers], Mask]) -> Iterator[tuple[Numbers, Numbers]]:
    """Some things at once that are equal to one of a lower number: the lowest such of each, and their own. ``keys``: of
    `keys_of`, in any order, which changes; ``equal``: whether things with some numbers are equal to others."""
    keys.sort()
    while keys.size:
        left, first = [], keys[0]
        for begin in range(0, keys.size, AT_ONCE):
            part = keys[begin : begin + AT_ONCE]
            new = np.diff(part >> np.uint64(bits), prepend=first >> np.uint64(bits)) != 0
            places = np.maximum.accumulate(np.where(new, np.arange(1, part.size + 1), 0))
            firsts = np.concatenate([[first], part])[places]
            first = firsts[-1]
            again = part != firsts
            one, other = ((some[again] & np.uint64((1 << bits) - 1)).astype(np.int64) for some in (firsts, part))
            same = equal(one, other)
            yield one[same], other[same]
            left.append(part[again][~same])
        keys = np.concatenate(left)  # whose fingerprints are those of others by chance
