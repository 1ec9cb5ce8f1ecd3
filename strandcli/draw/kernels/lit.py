"""Light across strands under exact shadows: of each column across a strand, what is lit along it and seen of it."""

from __future__ import annotations

import numpy as np

from ...jit import inlined, inner
from .approximations import clamp
from .masks import WHOLE, behind, ones, turned

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
TINY = np.float32(1e-12)
ONE = np.float32(1.0)
COLUMNS = 16
"""Columns of the offset h across a strand."""
LINES = COLUMNS
"""Lines along which exact shadows are traced, one in the middle of each column,"""
PLACES = 64
"""and places along each that are lit or dark: bits of a word,"""
BYTES = 8
"""which has so many bytes."""
ALL = np.uint64(0xFFFFFFFFFFFFFFFF)
UPRIGHT = np.float32(0.01)
"""Least share of a strand's way along either axis: what is less makes no difference."""


@inner
def lit(profile, shades, slot, after, t, half, bits, table, dx, dy, off, radius):
    """Mean departure of a piece between two vertices with these slots, where exact shadows leave it light, over what a
    sample shows of it: those of the sample's points that have a bit, or all of its area, and within `half` the piece's
    length of its place t. The piece goes by (dx, dy), and passes the sample's middle `off` aside.
    """
    since, until = places_of(t, half)
    mask = (ALL << np.uint64(since)) & (ALL >> np.uint64(PLACES - until))
    per = ONE / np.float32(until - since)
    begin, end, edge, column = columns_of(off, radius, dx, dy)
    total = r = g = b = x = y = z = ZERO  # of the vertex before and the one after
    if table is not None:  # noqa: SIM102  a branch of its own is left out where there are none
        if bits != WHOLE:
            turn = ONE if dx >= ZERO else -ONE
            way = turned(-dy * turn, dx * turn)
            lower = behind(table, way, turn, edge + np.float32(begin) * column)
            for i in range(begin, end):
                upper = behind(table, way, turn, edge + np.float32(i + 1) * column)
                here = ones(bits & upper & ~lower)
                lower = upper
                if here == 0:
                    continue
                total += np.float32(here)
                for row in range(profile.shape[0]):
                    share = np.float32(here)
                    if row > 0:
                        share = np.float32(here * ones(~shades[row - 1, slot, i] & mask)) * per
                    r += share * profile[row, slot, i + 1, 0]
                    g += share * profile[row, slot, i + 1, 1]
                    b += share * profile[row, slot, i + 1, 2]
                    x += share * profile[row, after, i + 1, 0]
                    y += share * profile[row, after, i + 1, 1]
                    z += share * profile[row, after, i + 1, 2]
    if total == ZERO:
        low = area(edge + np.float32(begin) * column, dx, dy)
        for i in range(begin, end):
            high = area(edge + np.float32(i + 1) * column, dx, dy)
            here_ = max(high - low, TINY)
            low = high
            total += here_
            for row in range(profile.shape[0]):
                share = here_
                if row > 0:
                    share *= np.float32(ones(~shades[row - 1, slot, i] & mask)) * per
                r += share * profile[row, slot, i + 1, 0]
                g += share * profile[row, slot, i + 1, 1]
                b += share * profile[row, slot, i + 1, 2]
                x += share * profile[row, after, i + 1, 0]
                y += share * profile[row, after, i + 1, 1]
                z += share * profile[row, after, i + 1, 2]
    per = ONE / total
    return (r + t * (x - r)) * per, (g + t * (y - g)) * per, (b + t * (z - b)) * per


@inlined
def places_of(t, half):
    """From which place on a line to before which a sample shows a piece, within `half` its length of its place t."""
    since = min(max(np.int64((t - half) * np.float32(PLACES)), 0), PLACES - 1)
    return since, max(min(np.int64((t + half) * np.float32(PLACES)) + 1, PLACES), since + 1)


@inlined
def columns_of(off, radius, dx, dy):
    """From which column to before which a sample shows a strand along (dx, dy) that passes its middle `off` aside; and
    how far from the middle, in samples, the first of all columns begins, and how wide each is."""
    reach = HALF * (abs(dx) + abs(dy))
    middle = HALF * np.float32(COLUMNS)
    most = np.float32(COLUMNS - 1)
    begin = np.int64(clamp(middle + (off - reach) * middle / radius, ZERO, most))
    end = np.int64(clamp(middle + (off + reach) * middle / radius, ZERO, most)) + 1
    return begin, end, -radius - off, radius / middle


@inner
def area(distance, dx, dy):
    """The share of a sample that lies before a line along (dx, dy), at a distance from the sample's middle."""
    long = max(abs(dx), abs(dy))
    short = max(min(abs(dx), abs(dy)), UPRIGHT)
    out = HALF * (long + short)
    in_ = HALF * (long - short)
    far = max(distance + out, ZERO) ** 2 - max(distance + in_, ZERO) ** 2
    near = max(distance - in_, ZERO) ** 2 - max(distance - out, ZERO) ** 2
    return (far - near) * HALF / (long * short)
