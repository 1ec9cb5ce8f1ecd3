"""Fragments of wide segments of strands in a tile: bands cut at mitred joints, so that a bend shows no notch.

The area of the band within a pixel is exact. At a joint it is reduced by the distance of the pixel's centre from the
joint's line, and the next segment covers just the rest. The depth of the band is that of the strand's round side toward
the eye; with that of the axis, strands that touch would be sorted wrongly.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....constants import VECTOR
from ....jit import inlined
from ....simd import half_width_pointer, lane_count, load, pointer, sqrt, store, where
from ...common.kernels.numbers import HALF, ONE, STEPS, TWO, ZERO
from ...geometry.kernels.ribbon import cross_section, make_ribbon
from . import segments as seg
from . import tiles
from .cells import write_fragment
from .crowds import count_visible

FLAT = np.float32(1 / 16)
"""Least slope that is drawn; single precision needs it, and the difference is invisible."""
FAINT = np.float32(1e-5)
"""Share of a cell up to which no fragment is made."""
OPAQUE = np.float32(1 - 1 / 512)
"""Opacity that hides everything behind it, as in `resolve`."""
TINY = np.float32(1e-30)
ROUNDED = np.float32(1e-3)
"""Pixels across by which more is examined than can be covered, for rounding."""
UNSEEN = np.float32(-1.0)
"""Depth number where a ribbon covers nothing: those behind which nothing is seen are not negative."""

LISTED = 64
"""Greatest number of pixels that are looked at together."""
# Rows of listed pixels: the coordinates a and b of `Ribbon`; position along the segment, 0 to 1; depth number; opacity;
# number of the pixel in the tile.
LANES = VECTOR // 2 // 4
"""Lanes of the vectors of a `half_width_pointer`."""
ROW = LISTED + LANES
COLUMN, LINE, ALONG, DEPTH, ALPHA, PIXEL = (i * ROW for i in range(6))
ROWS = 6


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
    narrow: np.float32
    """One over it."""
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


@inlined
def cover_ribbon(strands, widths, v, begin, i, scratch, target, m):
    """Append the fragments of the segment from vertex v − 1 to v to the m found so far; return their new number.

    strands: `fragments.Strands`; widths: of the strands, None: one pixel; begin: first vertex of its strand; i: its
    number in the rows of `segments.measure_joints`; scratch: `cells.Work`; target: `cells.Target`.
    """
    work, joints = scratch.ribbon, pointer(scratch.segments)
    screen = strands.screen
    w0 = ONE if widths is None else widths[v - 1]
    w1 = ONE if widths is None else widths[v]
    target.widest[0] = max(target.widest[0], max(w0, w1))
    flat = abs(screen[v, 0] - screen[v - 1, 0]) >= abs(screen[v, 1] - screen[v - 1, 1])
    ribbon = make_ribbon(
        screen, v, w0, w1, flat, (joints[seg.DX + i], joints[seg.DY + i], joints[seg.PER_SIZE + i]),
        (joints[seg.MX0 + i], joints[seg.MY0 + i]), (joints[seg.MX1 + i], joints[seg.MY1 + i]),
    )  # fmt: skip
    band = measure_band(ribbon)
    cells = find_cells(ribbon, w0, w1, target)
    past_lit = (v - 1 - begin) & (2 * strands.stride - 1)
    c = np.int64(cells.a_low)
    row = stop = np.int64(0)
    rows, steps = half_width_pointer(work), load(half_width_pointer(STEPS), 0)
    while True:
        n = np.int64(0)
        while n < LISTED:
            if row == stop:
                if c >= cells.a_high:
                    break
                row, stop = rows_of_cell(ribbon, band, c, cells)
                c += 1
            # a whole vector is written, and the next one overwrites the excess
            store(rows, COLUMN + n, np.float32(c - 1))
            store(rows, LINE + n, steps + np.float32(row))
            listed = min(stop - row, LISTED - n, LANES)
            n += listed
            row += listed
        if n > 0:
            cover_listed(work, n, ribbon, band, strands, target)
            m = add_listed(work, n, v - 1, past_lit, target, m)
        if row >= stop and c >= cells.a_high:
            return m


@inlined
def measure_band(ribbon):
    """Return the `Band` of a ribbon."""
    per = ONE / (ribbon.a1 - ribbon.a0)
    slope = (ribbon.b1 - ribbon.b0) * per
    square = ONE + slope * slope
    spread = max(abs(slope), FLAT)
    return Band(
        per, slope, HALF * math.sqrt(square), slope / square * per, spread, ONE / spread,
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
def rows_of_cell(ribbon, band, c, cells):
    """Return the first row that a ribbon's cell number c may cover, and the one behind the last."""
    past = np.float32(c) + HALF - ribbon.a0
    _, width, middle = cross_section(ribbon, band.per, band.slope, past)
    reach = band.tall * width + HALF * band.spread + ROUNDED
    first = max(np.int64(max(middle - reach, np.float32(cells.b_low))), cells.b_low)
    stop = min(rounded_up(min(middle + reach, np.float32(cells.b_high))), cells.b_high)
    return first, max(stop, first)


@inlined
def cover_listed(work, n, ribbon, band, strands, target):
    """Store what a ribbon has in the first n listed pixels: the rows from `ALONG` on."""
    rows = half_width_pointer(work)  # most ribbons touch few pixels
    left, top = np.float32(target.left), np.float32(target.top)
    for k in range(0, n, lane_count(rows)):
        column, row = load(rows, COLUMN + k), load(rows, LINE + k)
        past = column + HALF - ribbon.a0
        over_end = column + HALF - ribbon.a1
        along, width, middle = cross_section(ribbon, band.per, band.slope, past)
        h = band.tall * width
        rest = middle - row
        b = row + HALF
        begun = share_within(past * ribbon.ma0 + (b - ribbon.b0) * ribbon.mb0, band.inside0)
        ended = share_within(over_end * ribbon.ma1 + (b - ribbon.b1) * ribbon.mb1, band.inside1)
        cover = edge(rest + h, band.spread, band.narrow) - edge(rest - h, band.spread, band.narrow)
        cover = cover * (begun - ended)
        forward, tilt = offsets_across(ribbon, along, width, ribbon.a0 + past, middle, strands.depth_slope)
        # middle of the part of the width that the pixel shows
        off = HALF * (min(max(-rest, -h), h) + min(max(ONE - rest, -h), h))
        t = min(max(past * band.per + band.lean * off, ZERO), ONE)
        aside = off * (ONE / max(h, TINY))
        depth = ribbon.q0 + ribbon.rise * t + tilt * aside + forward * sqrt(max(ONE - aside * aside, ZERO))
        store(rows, ALONG + k, t)
        store(rows, DEPTH + k, where(cover > FAINT, depth, UNSEEN))
        store(rows, ALPHA + k, min(cover, ONE) * strands.opacity)
        x, y = (column, row) if ribbon.flat else (row, column)
        store(rows, PIXEL + k, (y - top) * np.float32(tiles.TILE_WIDTH) + (x - left))


@inlined
def add_listed(work, n, vertex, past_lit, target, m):
    """Append those of the first n listed pixels that a ribbon covers and nothing hides to the m fragments found so far;
    return their new number.

    vertex: the ribbon's first; past_lit: vertices from the lit one of even rank before it. An opaque fragment becomes
    the pixel's occlusion depth: of a thousand wide strands in a pixel, few are in front of all that came before. Each
    fragment is written, and the end of the list advances only past visible ones, as in `cells.cover_cells`.
    """
    o, most = np.uint64(m), np.int64(1) << target.place_bits
    for k in range(np.uint64(n)):
        pixel = np.int64(work[np.uint64(PIXEL) + k])
        depth, alpha = work[np.uint64(DEPTH) + k], work[np.uint64(ALPHA) + k]
        place = past_lit << target.place_bits | min(np.int64(work[np.uint64(ALONG) + k] * np.float32(most)), most - 1)
        write_fragment(target.found, o, depth, alpha, vertex, place, pixel)
        visible = count_visible(target, np.uint64(pixel), depth, alpha)
        if visible & (alpha > OPAQUE):
            target.occlusion_depth[np.uint64(pixel)] = depth
        o += np.uint64(visible)
    return np.int64(o)


@inlined
def offsets_across(ribbon, t, width, a, b, depth_slope):
    """Return `geometry.kernels.ribbon.offsets_across` of vectors."""
    x, y = (a, b) if ribbon.flat else (b, a)
    dx, dy = (ribbon.da, ribbon.db) if ribbon.flat else (ribbon.db, ribbon.da)
    q = ribbon.q0 + ribbon.rise * t
    per = depth_slope.per_depth * q + depth_slope.constant
    u = (x - depth_slope.axis_x) * depth_slope.per_depth
    v = (y - depth_slope.axis_y) * depth_slope.per_depth
    p = u * dx + v * dy
    w = v * dx - u * dy
    g = ribbon.steep / per
    slant = ONE - g * p
    scale = HALF * width * per / (ONE + w * w)
    forward, tilt = scale * sqrt(slant * slant + g * g * (ONE + w * w)), scale * w * slant
    turn = ONE if (dx if ribbon.flat else -dy) > ZERO else -ONE  # whether b grows toward (−dy, dx)
    return where(per > ZERO, forward, ZERO), where(per > ZERO, tilt * turn, ZERO)


@inlined
def share_within(past, inside):
    """Return the share of a pixel beyond a joint's line; past: signed distance of the pixel's centre from the line;
    inside: as in `Band`."""
    return min(max(past * inside + HALF, ZERO), ONE)


@inlined
def edge(height, spread, narrow):
    """Return the share of a pixel below an edge at a mean height above the pixel's lower side; spread: rise of the edge
    within the pixel; narrow: 1 / spread."""
    height = min(max(height, -ONE), TWO)
    return (ramp(height + HALF * spread) - ramp(height - HALF * spread)) * narrow


@inlined
def ramp(x):
    """Return the integral from 0 to x of x clipped to [0, 1]."""
    inside = min(max(x, ZERO), ONE)
    return HALF * inside * inside + max(x - ONE, ZERO)
