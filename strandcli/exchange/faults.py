"""Which strands are at fault."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from .growing import Growing
from .repeats import GOLDEN, Keys, keys_of, mixed, repeats
from .strands import CHUNK, Mask, Offsets, Strands, counts_in, spans

AT_ONCE = 1 << 24
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
    bits, turns = strands.count.bit_length(), -(-strands.count // AT_ONCE)
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
