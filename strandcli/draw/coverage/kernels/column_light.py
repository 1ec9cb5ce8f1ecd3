"""Light across strands under exact shadows: the lit and visible part of each column across a strand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....jit import device, inlined
from ...common.kernels.approximations import clamp
from ...common.kernels.bits import popcount
from .masks import ALL_POINTS, points_behind, table_row

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
TINY = np.float32(1e-12)
ONE = np.float32(1.0)
COLUMNS = 16
"""Columns of the offset h across a strand."""
LINES = COLUMNS
"""Lines along a segment on which exact shadows are traced, one in the middle of each column."""
PLACES = 64
"""Positions along each line that are lit or dark, one bit each."""
BYTES = 8
"""Bytes of a line's bits."""
ALL = np.uint64(0xFFFFFFFFFFFFFFFF)
UPRIGHT = np.float32(0.01)
"""Least component of a direction; a smaller one makes no difference."""


class Crossing(NamedTuple):
    """Position of a segment relative to a sample, in samples."""

    dx: np.float32
    dy: np.float32
    """Its unit direction."""
    off: np.float32
    """Distance from its axis to the sample's centre, toward (−dy, dx)."""
    radius: np.float32
    """Half its width."""


@device
def column_light(profile, shades, slot, after, t, half, points, table, crossing, shares):
    """Return (r, g, b): the mean departure from the average light of the part of a segment that a sample shows.

    slot, after: profiles of the vertices at its ends; t: position along it, 0 to 1; half: half the length that the
    sample shows, in lengths of the segment; profile, shades: as in `width_profiles.Profiles`; points, table, crossing,
    shares: as in `column_shares`.
    """
    since, until = places_of(t, half)
    mask = (ALL << np.uint64(since)) & (ALL >> np.uint64(PLACES - until))
    per = ONE / np.float32(until - since)
    begin, end, total = column_shares(points, table, crossing, shares)
    r = g = b = x = y = z = ZERO  # red, green and blue at the vertex before, and at the one after
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
def column_shares(points, table, crossing, shares):
    """Write how much a sample shows of each column of a strand; return begin and end of the columns shown, and the sum.

    points: mask of the sample's points that the strand shows; table: from `masks.half_planes`. Shares are counted in
    points, or measured as areas if table is None or no column has a point. crossing: `Crossing`; shares (COLUMNS,)
    float32: written from `begin` to before `end`.
    """
    dx, dy, off, radius = crossing
    reach = HALF * (abs(dx) + abs(dy))
    middle = HALF * np.float32(COLUMNS)
    most = np.float32(COLUMNS - 1)
    begin = np.int64(clamp(middle + (off - reach) * middle / radius, ZERO, most))
    end = np.int64(clamp(middle + (off + reach) * middle / radius, ZERO, most)) + 1
    edge = -radius - off  # of the first column, from the sample's centre
    column = radius / middle
    total = ZERO
    if table is not None:  # noqa: SIM102  a condition of its own is pruned if table is None
        if points != ALL_POINTS:
            turn = ONE if dx >= ZERO else -ONE
            normal = table_row(-dy * turn, dx * turn)
            lower = points_behind(table, normal, turn, edge + np.float32(begin) * column)
            for i in range(begin, end):
                upper = points_behind(table, normal, turn, edge + np.float32(i + 1) * column)
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
    """Return begin and end of the positions on a line, bits, that are within `half` of t, both in lengths of the
    segment; at least one."""
    since = min(max(np.int64((t - half) * np.float32(PLACES)), 0), PLACES - 1)
    return since, max(min(np.int64((t + half) * np.float32(PLACES)) + 1, PLACES), since + 1)


@device
def area(distance, dx, dy):
    """Return the share of a sample on one side of a line with the unit direction (dx, dy), at a signed distance from
    the sample's centre."""
    long = max(abs(dx), abs(dy))
    short = max(min(abs(dx), abs(dy)), UPRIGHT)
    out = HALF * (long + short)
    in_ = HALF * (long - short)
    far = max(distance + out, ZERO) ** 2 - max(distance + in_, ZERO) ** 2
    near = max(distance - in_, ZERO) ** 2 - max(distance - out, ZERO) ** 2
    return (far - near) * HALF / (long * short)
