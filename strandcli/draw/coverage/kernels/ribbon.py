"""What wide segments of strands cover of a tile: bands cut at mitred joints, so that a bend shows no notch.

Within a pixel the band is exact; what lies beyond an end is taken off by how far the pixel's middle is past the joint's
line, and the next segment covers just that. The band's depth is that of a strand's round side toward the eye, or
strands that touch would be seen in the wrong order.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....jit import device, inlined
from ...geometry.kernels.ribbon import cross_section, measure_ribbon, offsets_across, round_depth
from .cells import add_fragment
from .tiles import ROW_BITS, fixed

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
FLAT = np.float32(1 / 16)
"""A lesser slope is drawn as this one: single precision needs it, and the difference cannot be seen."""
FAINT = np.float32(1e-5)
"""Share of a cell that is not worth a fragment."""
OPAQUE = np.float32(1 - 1 / 512)
"""Opacity behind which nothing matters, as in `composite`."""
TINY = np.float32(1e-30)


class Band(NamedTuple):
    """What is the same for all cells of a ribbon."""

    per: np.float32
    """One over the ribbon's way along."""
    slope: np.float32
    """Its rise across over its way along."""
    tall: np.float32
    """Half of its height across over its width."""
    lean: np.float32
    """How much further along the ribbon the nearest point of its middle lies, for each pixel aside."""
    spread: np.float32
    """The rise of its edges within a cell, pixels."""
    inside0: np.float32
    inside1: np.float32
    """For the joint at each end, one over how far its line moves while it crosses a pixel."""


class Cells(NamedTuple):
    """The cells a_low <= a < a_high of a ribbon, of the rows b_low <= b < b_high; columns where a ribbon follows y."""

    a_low: int
    a_high: int
    b_low: int
    b_high: int


@device
def cover_ribbon(strands, widths, v, begin, end, target, m):
    """Add what the segment from vertex v − 1 to v of the strand begin … end − 1 covers to the m fragments found before;
    returns how many there are then.

    strands: `fragments.Strands`; widths: theirs; target: see `cells.Target`.
    """
    screen = strands.screen
    w0 = ONE if widths is None else widths[v - 1]
    w1 = ONE if widths is None else widths[v]
    flat = abs(screen[v, 0] - screen[v - 1, 0]) >= abs(screen[v, 1] - screen[v - 1, 1])
    ribbon = measure_ribbon(screen, v, begin, end, w0, w1, flat)
    band = measure_band(ribbon)
    cells = find_cells(ribbon, w0, w1, target)
    lit_past = (v - 1 - begin) & (strands.stride - 1)  # how many vertices v − 1 is past a lit one
    for c in range(cells.a_low, cells.a_high):
        m = cover_cell(ribbon, band, c, cells, strands, v - 1, lit_past, target, m)
    return m


@inlined
def measure_band(ribbon):
    """The `Band` of a ribbon."""
    per = ONE / (ribbon.a1 - ribbon.a0)
    slope = (ribbon.b1 - ribbon.b0) * per
    square = ONE + slope * slope
    return Band(
        per, slope, HALF * math.sqrt(square), slope / square * per, max(abs(slope), FLAT),
        ONE / (abs(ribbon.ma0) + abs(ribbon.mb0)), ONE / (abs(ribbon.ma1) + abs(ribbon.mb1)),
    )  # fmt: skip


@inlined
def find_cells(ribbon, w0, w1, target):
    """The `Cells` of the tile in the box of a ribbon's four corners, and half a pixel about it."""
    a0, b0, a1, b1 = ribbon.a0, ribbon.b0, ribbon.a1, ribbon.b1
    reach0 = HALF * w0 / (ribbon.ma0 * ribbon.da + ribbon.mb0 * ribbon.db)
    reach1 = HALF * w1 / (ribbon.ma1 * ribbon.da + ribbon.mb1 * ribbon.db)
    a_reach0, b_reach0 = reach0 * abs(ribbon.mb0), reach0 * abs(ribbon.ma0)
    a_reach1, b_reach1 = reach1 * abs(ribbon.mb1), reach1 * abs(ribbon.ma1)
    left, right = np.float32(target.left), np.float32(target.right)
    top, bottom = np.float32(target.top), np.float32(target.bottom)
    a_least, a_most, b_least, b_most = (left, right, top, bottom) if ribbon.flat else (top, bottom, left, right)
    a_low = np.int64(math.floor(max(min(a0 - a_reach0, a1 - a_reach1) - HALF, a_least)))
    a_high = np.int64(math.ceil(min(max(a0 + a_reach0, a1 + a_reach1) + HALF, a_most)))
    b_low = np.int64(math.floor(max(min(b0 - b_reach0, b1 - b_reach1) - HALF, b_least)))
    b_high = np.int64(math.ceil(min(max(b0 + b_reach0, b1 + b_reach1) + HALF, b_most)))
    return Cells(a_low, a_high if b_low < b_high else a_low, b_low, b_high)


@inlined
def cover_cell(ribbon, band, c, cells, strands, vertex, lit_past, target, m):
    """Add what a ribbon covers of its cell number c to the m fragments found before; returns how many there are then.

    vertex: the ribbon's first, which is `lit_past` vertices past a lit one. Where the ribbon hides all that is behind
    it, the pixel's occlusion depth comes forward to it: of a thousand wide strands in a pixel, few are in front of all
    before them.
    """
    spread = band.spread
    narrow = ONE / spread
    centre = np.float32(c) + HALF
    past = centre - ribbon.a0
    left = centre - ribbon.a1
    t, width, middle = cross_section(ribbon, band.per, band.slope, past)
    forward, tilt = offsets_across(ribbon, t, width, ribbon.a0 + past, middle, strands.depth_slope)
    h = band.tall * width
    over = ONE / max(h, TINY)
    first = max(np.int64(math.floor(max(middle - h - spread, np.float32(cells.b_low)))), cells.b_low)
    stop = min(np.int64(math.ceil(min(middle + h + spread, np.float32(cells.b_high)))), cells.b_high)
    for row in range(first, stop):
        x, y = (c, row) if ribbon.flat else (row, c)
        pixel = (y - target.top) << ROW_BITS | (x - target.left)
        rest = middle - np.float32(row)
        # of what the pixel shows of the width
        off = HALF * (min(max(-rest, -h), h) + min(max(ONE - rest, -h), h))
        t = min(max(past * band.per + band.lean * off, ZERO), ONE)
        depth = round_depth(ribbon, t, off * over, forward, tilt)
        if not depth >= target.occlusion_depth[pixel]:
            continue
        b = np.float32(row) + HALF
        begun = share_within(past * ribbon.ma0 + (b - ribbon.b0) * ribbon.mb0, band.inside0)
        ended = share_within(left * ribbon.ma1 + (b - ribbon.b1) * ribbon.mb1, band.inside1)
        cover = edge(rest + h, spread, narrow) - edge(rest - h, spread, narrow)
        cover *= begun - ended
        if cover > FAINT:
            alpha = min(cover, ONE) * strands.opacity
            if alpha > OPAQUE:
                target.occlusion_depth[pixel] = depth
            place = fixed(t, lit_past, target.place_bits)
            m = add_fragment(target, m, depth, alpha, vertex, place, pixel)
    return m


@inlined
def share_within(past, inside):
    """Share of a pixel that lies beyond a joint's line, which is crossed where the pixel's middle is `past` 0."""
    return min(max(past * inside + HALF, ZERO), ONE)


@device
def edge(height, spread, narrow):
    """How much of a pixel's column lies under an edge at this height above the row, averaged over the edge's rise."""
    height = min(max(height, -ONE), TWO)
    return (ramp(height + HALF * spread) - ramp(height - HALF * spread)) * narrow


@device
def ramp(x):
    """Integral of x clipped to [0, 1]."""
    inside = min(max(x, ZERO), ONE)
    return HALF * inside * inside + max(x - ONE, ZERO)
