"""Light across strands under exact shadows: of each column across a strand, what is lit along it and seen of it."""

from __future__ import annotations

import numpy as np

from ...jit import inlined, inner
from .approximations import clamp
from .masks import REACH, WHOLE, behind, ones, turned

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
COLUMNS = 16
"""Columns of the offset h across a strand."""
LINES = COLUMNS
"""Lines along which exact shadows are traced, one in the middle of each column,"""
PLACES = 64
"""and places along each that are lit or dark: bits of a word."""
ALL = np.uint64(0xFFFFFFFFFFFFFFFF)


@inner
def lit(profile, shades, slot, after, low, high, t, half, bits, table, dx, dy, off, radius):
    """Mean departure of a piece between two vertices with these slots, where exact shadows leave it light: between the
    offsets `low` and `high`, in columns, or at those points of the sample alone that have a bit, and within `half` the
    piece's length of its place t. The piece goes by (dx, dy), and passes the sample's middle `off` aside."""
    since = min(max(np.int64((t - half) * np.float32(PLACES)), 0), PLACES - 1)
    until = max(min(np.int64((t + half) * np.float32(PLACES)) + 1, PLACES), since + 1)
    mask = (ALL << np.uint64(since)) & (ALL >> np.uint64(PLACES - until))
    per = ONE / np.float32(until - since)
    if table is not None:  # noqa: SIM102  a branch of its own is left out where there are none
        if bits != WHOLE:
            points, r, g, b = at_points(
                profile, shades, slot, after, t, mask, per, bits, table, dx, dy, off, radius
            )  # fmt: skip
            if points > ZERO:
                per = ONE / points
                return r * per, g * per, b * per
    r = even(profile, 0, slot, after, 0, high, t) - even(profile, 0, slot, after, 0, low, t)
    g = even(profile, 0, slot, after, 1, high, t) - even(profile, 0, slot, after, 1, low, t)
    b = even(profile, 0, slot, after, 2, high, t) - even(profile, 0, slot, after, 2, low, t)
    begin = np.int64(low)
    end = min(np.int64(high) + 1, LINES)
    for row in range(1, profile.shape[0]):
        for line in range(begin, end):
            count = ones(~shades[row - 1, slot, line] & mask)
            if count == 0:
                continue
            share = np.float32(count) * per
            one = max(low, np.float32(line))
            two = min(high, np.float32(line + 1))
            r += share * (even(profile, row, slot, after, 0, two, t) - even(profile, row, slot, after, 0, one, t))
            g += share * (even(profile, row, slot, after, 1, two, t) - even(profile, row, slot, after, 1, one, t))
            b += share * (even(profile, row, slot, after, 2, two, t) - even(profile, row, slot, after, 2, one, t))
    per = ONE / (high - low)
    return r * per, g * per, b * per


@inner
def at_points(profile, shades, slot, after, t, mask, per, bits, table, dx, dy, off, radius):
    """What `lit` is the mean of, summed over the points of a sample with a bit, and how many they are."""
    turn = ONE if dx >= ZERO else -ONE
    way = turned(-dy * turn, dx * turn)
    middle = HALF * np.float32(COLUMNS)
    to_column = middle / radius
    column = radius / middle
    begin = np.int64(clamp(middle + (off - REACH) * to_column, ZERO, np.float32(COLUMNS - 1)))
    end = np.int64(clamp(middle + (off + REACH) * to_column, ZERO, np.float32(COLUMNS - 1))) + 1
    lower = behind(table, way, turn, np.float32(begin) * column - radius - off)
    points = r = g = b = ZERO
    for i in range(begin, end):
        upper = behind(table, way, turn, np.float32(i + 1) * column - radius - off)
        here = ones(bits & upper & ~lower)
        lower = upper
        if here == 0:
            continue
        share = np.float32(here)
        points += share
        for row in range(profile.shape[0]):
            if row > 0:
                share = np.float32(here * ones(~shades[row - 1, slot, i] & mask)) * per
            r += share * column_of(profile, row, slot, after, i, 0, t)
            g += share * column_of(profile, row, slot, after, i, 1, t)
            b += share * column_of(profile, row, slot, after, i, 2, t)
    return points, r, g, b


@inlined
def column_of(profile, row, slot, after, i, c, t):
    """The light of a column, between two vertices, of what `add_up` made."""
    one = profile[row, slot, i + 1, c] - profile[row, slot, i, c]
    two = profile[row, after, i + 1, c] - profile[row, after, i, c]
    return one + t * (two - one)


@inlined
def even(profile, row, slot, after, c, place, t):
    """What `add_up` made at a place in [0, COLUMNS], between two vertices: light is even within a column."""
    i = min(np.int64(place), COLUMNS - 1)
    part = place - np.float32(i)
    one = profile[row, slot, i, c] + part * (profile[row, slot, i + 1, c] - profile[row, slot, i, c])
    two = profile[row, after, i, c] + part * (profile[row, after, i + 1, c] - profile[row, after, i, c])
    return one + t * (two - one)
