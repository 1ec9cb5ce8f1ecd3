"""Which strands are at fault."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from .edit.subsample import GOLDEN, mixed
from .growing import Growing
from .strands import CHUNK, Mask, Offsets, Strands, counts_in, spans

AT_ONCE = 1 << 24
"""Strands that are compared at once, each by a number of 8 bytes."""
Keys = npt.NDArray[np.uint64]


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
    bits = strands.count.bit_length()
    turns = -(-strands.count // AT_ONCE)
    for turn in range(turns):
        keys = _keys(strands, bits, turn, turns)
        keys.sort()
        while keys.size:  # those that are equal to the first of their key are found
            keys = _found(strands, keys, bits, found)
    return found


def _keys(strands: Strands, bits: int, turn: int, turns: int) -> Keys:
    """Of strands whose fingerprint is ``turn`` modulo ``turns``: its upper bits, and in the lower ``bits`` the number
    of the strand."""
    keys = Growing(np.uint64)
    below = np.uint64((1 << bits) - 1)
    for rows, prints in fingerprints(strands):
        own = np.arange(rows.start, rows.stop, dtype=np.uint64)
        if turns > 1:
            some = prints % np.uint64(turns) == turn
            prints, own = prints[some], own[some]
        keys.add((prints & ~below) | own)
    return keys.taken()


def _found(strands: Strands, keys: Keys, bits: int, found: Mask) -> Keys:
    """Note strands that are equal to the first one of those with the same fingerprint; the keys of others but the
    first, whose fingerprint is the same by chance."""
    left, first = [], keys[0]
    for begin in range(0, keys.size, CHUNK):
        part = keys[begin : begin + CHUNK]
        prints = part >> np.uint64(bits)
        new = np.diff(prints, prepend=first >> np.uint64(bits)) != 0
        firsts = np.concatenate([[first], part])[np.maximum.accumulate(np.where(new, np.arange(1, part.size + 1), 0))]
        first = firsts[-1]
        again = part != firsts
        numbers = [(one[again] & np.uint64((1 << bits) - 1)).astype(np.int64) for one in (firsts, part)]
        same = _equal(strands, *numbers)
        found[numbers[1][same]] = True
        left.append(part[again][~same])
    return np.concatenate(left)


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
