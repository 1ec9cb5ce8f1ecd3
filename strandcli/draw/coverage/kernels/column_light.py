"""Light across strands under exact shadows: of each column across a strand, what is lit along it and seen of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....jit import device, inlined
from ...common.kernels.approximations import clamp
from ...common.kernels.bits import popcount
from .masks import WHOLE, points_behind, table_row

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


class Crossing(NamedTuple):
    """How a piece of a strand passes a sample, in samples."""

    dx: np.float32
    dy: np.float32
    """Its direction, of length 1."""
    off: np.float32
    """Distance from its middle line to the sample's middle, toward (−dy, dx)."""
    radius: np.float32
    """Half its width."""


@device
def column_light(profile, shades, slot, after, t, half, points, table, crossing, shares):
    """(r, g, b): mean departure of a piece between two vertices with these slots, where exact shadows leave it light,
    over what a sample shows of it: of its columns what `columns` tells, and within `half` the piece's length of its
    place t.

    profile, shades: as in `width_profiles.Profiles`; points, table, crossing, shares: as in `columns`.
    """
    since, until = places_of(t, half)
    mask = (ALL << np.uint64(since)) & (ALL >> np.uint64(PLACES - until))
    per = ONE / np.float32(until - since)
    begin, end, total = columns(points, table, crossing, shares)
    r = g = b = x = y = z = ZERO  # of the vertex before and the one after
    for i in range(begin, end):
        if shares[i] == ZERO:
            continue
        for row in range(profile.shape[0]):
            share = shares[i]
            if row > 0:
                share *= np.float32(popcount(~shades[row - 1, slot, i] & mask)) * per
            r += share * profile[row, slot, i + 1, 0]
            g += share * profile[row, slot, i + 1, 1]
            b += share * profile[row, slot, i + 1, 2]
            x += share * profile[row, after, i + 1, 0]
            y += share * profile[row, after, i + 1, 1]
            z += share * profile[row, after, i + 1, 2]
    per = ONE / total
    return (r + t * (x - r)) * per, (g + t * (y - g)) * per, (b + t * (z - b)) * per


@device
def columns(points, table, crossing, shares):
    """How much a sample shows of each column of a strand: as many of the sample's points as are set in `points`, or all
    of the area, where none is or there is no `masks.sides` for a table.

    shares (COLUMNS,) float32 is written from the first column that is shown to before the last. Returns which these
    are, and the sum.
    """
    dx, dy, off, radius = crossing
    reach = HALF * (abs(dx) + abs(dy))
    middle = HALF * np.float32(COLUMNS)
    most = np.float32(COLUMNS - 1)
    begin = np.int64(clamp(middle + (off - reach) * middle / radius, ZERO, most))
    end = np.int64(clamp(middle + (off + reach) * middle / radius, ZERO, most)) + 1
    edge = -radius - off  # of the first column, from the sample's middle
    column = radius / middle
    total = ZERO
    if table is not None:  # noqa: SIM102  a branch of its own is left out where there are none
        if points != WHOLE:
            turn = ONE if dx >= ZERO else -ONE
            way = table_row(-dy * turn, dx * turn)
            lower = points_behind(table, way, turn, edge + np.float32(begin) * column)
            for i in range(begin, end):
                upper = points_behind(table, way, turn, edge + np.float32(i + 1) * column)
                shares[i] = np.float32(popcount(points & upper & ~lower))
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
