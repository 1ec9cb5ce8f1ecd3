"""Fragments of wide segments of strands in a tile: bands cut at mitred joints, so that a bend shows no notch.

The area of the band within a pixel is exact. At a joint it is reduced by the distance of the pixel's centre from the
joint's line, and the next segment covers just the rest. The depth of the band is that of the strand's round side toward
the eye; with that of the axis, strands that touch would be sorted wrongly.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....jit import device, inlined
from ...geometry.kernels.ribbon import cross_section, measure_ribbon, offsets_across, round_depth
from .cells import add_fragment
from .tiles import ROW_BITS, fixed_point

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
FLAT = np.float32(1 / 16)
"""Least slope that is drawn; single precision needs it, and the difference is invisible."""
FAINT = np.float32(1e-5)
"""Share of a cell up to which no fragment is made."""
OPAQUE = np.float32(1 - 1 / 512)
"""Opacity that hides everything behind it, as in `composite`."""
TINY = np.float32(1e-30)
ROUNDED = np.float32(1e-3)
"""Pixels across by which more is examined than can be covered, for rounding."""


class Band(NamedTuple):
    """Numbers of a ribbon that all its cells share; along and across: the coordinates a and b of `Ribbon`."""

    per: np.float32
    """One over the length along."""
    slope: np.float32
    """Rise across over length along."""
    tall: np.float32
    """Half the height across over the width."""
    lean: np.float32
    """Change of t at the nearest point of the axis, for each pixel across."""
    spread: np.float32
    """Rise of the edges within a cell, pixels."""
    inside0: np.float32
    inside1: np.float32
    """For the joint at each end, one over the distance that its line moves while it crosses a pixel."""


class Cells(NamedTuple):
    """The part a_low <= a < a_high, b_low <= b < b_high of a tile, in the coordinates of a `Ribbon`; cells are pixels
    with the same a."""

    a_low: int
    a_high: int
    b_low: int
    b_high: int


@device
def cover_ribbon(strands, widths, v, begin, end, target, m):
    """Append the fragments of the segment from vertex v − 1 to v of the strand begin … end − 1 to the m found so far;
    return their new number.

    strands: `fragments.Strands`; widths: of the strands, None: one pixel; target: `cells.Target`.
    """
    screen = strands.screen
    w0 = ONE if widths is None else widths[v - 1]
    w1 = ONE if widths is None else widths[v]
    flat = abs(screen[v, 0] - screen[v - 1, 0]) >= abs(screen[v, 1] - screen[v - 1, 1])
    ribbon = measure_ribbon(screen, v, begin, end, w0, w1, flat)
    band = measure_band(ribbon)
    cells = find_cells(ribbon, w0, w1, target)
    past_lit = (v - 1 - begin) & (strands.stride - 1)
    for c in range(cells.a_low, cells.a_high):
        m = cover_cell(ribbon, band, c, cells, strands, v - 1, past_lit, target, m)
    return m


@inlined
def measure_band(ribbon):
    """Return the `Band` of a ribbon."""
    per = ONE / (ribbon.a1 - ribbon.a0)
    slope = (ribbon.b1 - ribbon.b0) * per
    square = ONE + slope * slope
    return Band(
        per, slope, HALF * math.sqrt(square), slope / square * per, max(abs(slope), FLAT),
        ONE / (abs(ribbon.ma0) + abs(ribbon.mb0)), ONE / (abs(ribbon.ma1) + abs(ribbon.mb1)),
    )  # fmt: skip


@inlined
def find_cells(ribbon, w0, w1, target):
    """Return the `Cells` of the tile within half a pixel of the bounding box of a ribbon's four corners."""
    a0, b0, a1, b1 = ribbon.a0, ribbon.b0, ribbon.a1, ribbon.b1
    reach0 = HALF * w0 / (ribbon.ma0 * ribbon.da + ribbon.mb0 * ribbon.db)
    reach1 = HALF * w1 / (ribbon.ma1 * ribbon.da + ribbon.mb1 * ribbon.db)
    a_reach0, b_reach0 = reach0 * abs(ribbon.mb0), reach0 * abs(ribbon.ma0)
    a_reach1, b_reach1 = reach1 * abs(ribbon.mb1), reach1 * abs(ribbon.ma1)
    left, right = np.float32(target.left), np.float32(target.right)
    top, bottom = np.float32(target.top), np.float32(target.bottom)
    a_least, a_most, b_least, b_most = (left, right, top, bottom) if ribbon.flat else (top, bottom, left, right)
    a_low = np.int64(max(min(a0 - a_reach0, a1 - a_reach1) - HALF, a_least))  # of a number that is not negative: down
    a_high = rounded_up(min(max(a0 + a_reach0, a1 + a_reach1) + HALF, a_most))
    b_low = np.int64(max(min(b0 - b_reach0, b1 - b_reach1) - HALF, b_least))
    b_high = rounded_up(min(max(b0 + b_reach0, b1 + b_reach1) + HALF, b_most))
    return Cells(a_low, a_high if b_low < b_high else a_low, b_low, b_high)


@inlined
def rounded_up(x):
    """Return the least integer that is not less than x. Numba's ceil is a call of the C library."""
    whole = np.int64(x)
    return whole + np.int64(x > np.float32(whole))


@inlined
def cover_cell(ribbon, band, c, cells, strands, vertex, past_lit, target, m):
    """Append the fragments of a ribbon's cell number c to the m found so far; return their new number.

    vertex: the ribbon's first; past_lit: vertices from the lit one before it to that. An opaque fragment becomes the
    pixel's occlusion depth: of a thousand wide strands in a pixel, few are in front of all that came before.
    """
    spread = band.spread
    narrow = ONE / spread
    past = np.float32(c) + HALF - ribbon.a0
    left = np.float32(c) + HALF - ribbon.a1
    along, width, middle = cross_section(ribbon, band.per, band.slope, past)
    h = band.tall * width
    over = ONE / max(h, TINY)
    reach = h + HALF * spread + ROUNDED
    first = max(np.int64(max(middle - reach, np.float32(cells.b_low))), cells.b_low)
    stop = min(rounded_up(min(middle + reach, np.float32(cells.b_high))), cells.b_high)
    forward = tilt = ZERO
    measured = False
    for row in range(first, stop):
        rest = middle - np.float32(row)
        b = np.float32(row) + HALF
        begun = share_within(past * ribbon.ma0 + (b - ribbon.b0) * ribbon.mb0, band.inside0)
        ended = share_within(left * ribbon.ma1 + (b - ribbon.b1) * ribbon.mb1, band.inside1)
        cover = edge(rest + h, spread, narrow) - edge(rest - h, spread, narrow)
        cover *= begun - ended
        if not cover > FAINT:
            continue
        if not measured:  # many cells at the ends of a short ribbon show nothing
            forward, tilt = offsets_across(ribbon, along, width, ribbon.a0 + past, middle, strands.depth_slope)
            measured = True
        x, y = (c, row) if ribbon.flat else (row, c)
        pixel = (y - target.top) << ROW_BITS | (x - target.left)
        # middle of the part of the width that the pixel shows
        off = HALF * (min(max(-rest, -h), h) + min(max(ONE - rest, -h), h))
        t = min(max(past * band.per + band.lean * off, ZERO), ONE)
        depth = round_depth(ribbon, t, off * over, forward, tilt)
        if not depth >= target.occlusion_depth[pixel]:
            continue
        alpha = min(cover, ONE) * strands.opacity
        if alpha > OPAQUE:
            target.occlusion_depth[pixel] = depth
        place = fixed_point(t, past_lit, target.place_bits)
        m = add_fragment(target, m, depth, alpha, vertex, place, pixel)
    return m


@inlined
def share_within(past, inside):
    """Return the share of a pixel beyond a joint's line; past: signed distance of the pixel's centre from the line;
    inside: as in `Band`."""
    return min(max(past * inside + HALF, ZERO), ONE)


@device
def edge(height, spread, narrow):
    """Return the share of a pixel below an edge at a mean height above the pixel's lower side; spread: rise of the edge
    within the pixel; narrow: 1 / spread."""
    height = min(max(height, -ONE), TWO)
    return (ramp(height + HALF * spread) - ramp(height - HALF * spread)) * narrow


@device
def ramp(x):
    """Return the integral from 0 to x of x clipped to [0, 1]."""
    inside = min(max(x, ZERO), ONE)
    return HALF * inside * inside + max(x - ONE, ZERO)
