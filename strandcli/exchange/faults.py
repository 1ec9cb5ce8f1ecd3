"""Which strands are at fault, and which things are equal, told by fingerprints, in eight bytes of each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from .bounded import Growing
from .strands import CHUNK, Mask, Offsets, Strands, counts_in, spans

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


MOST_KEYS = 1 << 24
"""Strands that are compared at once, each by a number of 8 bytes."""


def not_finite(strands: Strands) -> Mask:
    """Strands (S,) of which a point is NaN or infinite."""
    found = np.zeros(strands.count, np.bool_)
    for rows, points in spans(strands.first):
        wrong = ~np.isfinite(strands.points[points]).all(axis=1)
        if wrong.any():
            found[rows] |= np.logical_or.reduceat(wrong, np.maximum(strands.first[rows] - points.start, 0))
    return found


def without_length(strands: Strands) -> Mask:
    """Strands (S,) whose points are all in one place."""
    found = np.empty(strands.count, np.bool_)
    for begin in range(0, found.size, CHUNK):
        first = strands.first[begin : begin + CHUNK + 1]
        found[begin : begin + CHUNK] = (strands.points[first[:-1]] == strands.points[first[1:] - 1]).all(axis=1)
    if found.any():  # the others have a length for sure
        found[found] = replace(strands, spent=False).select(found).lengths() == 0
    return found


def repeated(strands: Strands) -> Mask:
    """Strands (S,) that have the points of an earlier one, in every bit."""
    found = np.zeros(strands.count, np.bool_)
    bits, turns = strands.count.bit_length(), -(-strands.count // MOST_KEYS)
    for turn in range(turns):
        keys = Growing(np.uint64)
        for rows, prints in fingerprints(strands):
            own = keys_of(prints, range(rows.start, rows.stop), bits)
            keys.add(own if turns == 1 else own[prints % np.uint64(turns) == turn])
        for _, again in repeats(keys.taken(), bits, lambda one, other: _equal(strands, one, other)):
            found[again] = True
    return found


def _equal(strands: Strands, one: Offsets, other: Offsets) -> Mask:
    """Whether strands have the same bits, pair by pair."""
    counts = [strands.first[side + 1] - strands.first[side] for side in (one, other)]
    found: Mask = counts[0] == counts[1]
    pairs = np.flatnonzero(found)
    bits = strands.points.view(np.uint32)
    first = np.zeros(pairs.size + 1, np.int64)
    np.cumsum(counts[0][pairs], out=first[1:])
    for rows, points in spans(first):
        each = counts_in(first, rows, points)
        place = np.arange(points.start, points.stop) - np.repeat(first[rows], each)
        sides = [place + np.repeat(strands.first[side[pairs[rows]]], each) for side in (one, other)]
        same = (bits[sides[0]] == bits[sides[1]]).all(axis=1)
        found[pairs[rows]] &= np.logical_and.reduceat(same, np.maximum(first[rows] - points.start, 0))
    return found


def fingerprints(strands: Strands) -> Iterator[tuple[slice, Keys]]:
    """Of some strands at once a number of the bits of each: equal strands have equal ones, others hardly ever."""
    third, held = mixed(np.array([GOLDEN], np.uint64)), np.uint64(0)
    for rows, points in spans(strands.first):
        begins = np.maximum(strands.first[rows] - points.start, 0)
        each = counts_in(strands.first, rows, points)
        with np.errstate(over="ignore"):
            place = np.arange(points.start, points.stop) - np.repeat(strands.first[rows], each)
            factor = mixed(place.astype(np.uint64) * np.uint64(GOLDEN) + np.uint64(1)) | np.uint64(1)
            bits = strands.points[points].view(np.uint32).astype(np.uint64)
            whole = bits[:, 0] + bits[:, 1] * np.uint64(GOLDEN) + bits[:, 2] * third
            found = held + np.add.reduceat(mixed(whole + np.uint64(GOLDEN)) * factor, begins)
        held = np.uint64(0)
        if points.stop == strands.first[rows.stop]:
            yield rows, found
        else:
            held = found[0]
