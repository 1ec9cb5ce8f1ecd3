"""Light across strands under exact shadows: of each column across a strand, what is lit along it and seen of it."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ...common.kernels.approximations import clamp
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


@device
def lit(profile, shades, slot, after, t, half, bits, table, dx, dy, off, radius, shares):
    """Mean departure of a piece between two vertices with these slots, where exact shadows leave it light, over what a
    sample shows of it: of its columns what `columns` tells, and within `half` the piece's length of its place t.
    """
    since, until = places_of(t, half)
    mask = (ALL << np.uint64(since)) & (ALL >> np.uint64(PLACES - until))
    per = ONE / np.float32(until - since)
    begin, end, total = columns(bits, table, dx, dy, off, radius, shares)
    r = g = b = x = y = z = ZERO  # of the vertex before and the one after
    for i in range(begin, end):
        if shares[i] == ZERO:
            continue
        for row in range(profile.shape[0]):
            share = shares[i]
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


@device
def columns(bits, table, dx, dy, off, radius, shares):
    """How much a sample shows of each column of a strand along (dx, dy) that passes its middle `off` aside: as many of
    the sample's points as have a bit, or all of the area, where none has or there is no `masks.sides` for a table.

    shares (COLUMNS,) float32 is written from the first column that is shown to before the last. Returns which these
    are, and the sum.
    """
    reach = HALF * (abs(dx) + abs(dy))
    middle = HALF * np.float32(COLUMNS)
    most = np.float32(COLUMNS - 1)
    begin = np.int64(clamp(middle + (off - reach) * middle / radius, ZERO, most))
    end = np.int64(clamp(middle + (off + reach) * middle / radius, ZERO, most)) + 1
    edge = -radius - off  # of the first column, from the sample's middle
    column = radius / middle
    total = ZERO
    if table is not None:  # noqa: SIM102  a branch of its own is left out where there are none
        if bits != WHOLE:
            turn = ONE if dx >= ZERO else -ONE
            way = turned(-dy * turn, dx * turn)
            lower = behind(table, way, turn, edge + np.float32(begin) * column)
            for i in range(begin, end):
                upper = behind(table, way, turn, edge + np.float32(i + 1) * column)
                shares[i] = np.float32(ones(bits & upper & ~lower))
                total += shares[i]
                lower = upper
    if total == ZERO:
        low = area(edge + np.float32(begin) * column, dx, dy)
        for i in range(begin, end):
            high = area(edge + np.float32(i + 1) * column, dx, dy)
            shares[i] = max(high - low, TINY)
            total += shares[i]
            low = high
    return begin, end, total


@inlined
def places_of(t, half):
    """From which place on a line to before which a sample shows a piece, within `half` its length of its place t."""
    since = min(max(np.int64((t - half) * np.float32(PLACES)), 0), PLACES - 1)
    return since, max(min(np.int64((t + half) * np.float32(PLACES)) + 1, PLACES), since + 1)


@device
def area(distance, dx, dy):
    """The share of a sample that lies before a line along (dx, dy), at a distance from the sample's middle."""
    long = max(abs(dx), abs(dy))
    short = max(min(abs(dx), abs(dy)), UPRIGHT)
    out = HALF * (long + short)
    in_ = HALF * (long - short)
    far = max(distance + out, ZERO) ** 2 - max(distance + in_, ZERO) ** 2
    near = max(distance - in_, ZERO) ** 2 - max(distance - out, ZERO) ** 2
    return (far - near) * HALF / (long * short)
