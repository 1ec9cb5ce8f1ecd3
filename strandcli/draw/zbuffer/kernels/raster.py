"""Rasterisation of lines and ribbons into a z-buffer that holds, for each pixel, the visible segment.

A pixel holds one 64-bit key: the depth number, complemented so that nearer is smaller, above the index of the
segment's first vertex. The smallest key wins, and equal depths go to the lower index, so neither the order of drawing
nor the number of threads can change a picture. Colours are computed afterwards, for visible segments alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined, parallel, prange
from ...common.kernels.numbers import HALF, ONE, ZERO
from ...geometry.kernels.ribbon import (
    GREATEST_Y,
    LEAST_Y,
    cross_section,
    direction,
    make_ribbon,
    mitre,
    offsets_across,
)
from .lines import PART, Steps, Window, deposit, draw_lines

TINY = np.float32(1e-6)
"""Pixels. A shorter segment draws nothing."""
CLOSE = np.float32(1e-6)
"""Cosine of 1 less so much: directions that are the same but for rounding."""


class Sides(NamedTuple):
    """Numbers of a ribbon that all its columns of pixels share, or all its rows if it follows y."""

    round0: bool
    round1: bool
    """Whether beginning and end have round caps."""
    w0: np.float32
    w1: np.float32
    """Width at beginning and end, pixels."""
    low: np.float32
    high: np.float32
    """Pixels across that are in the window: low … high − 1."""
    along: int
    across: int
    """Steps in `keys` for a pixel along and a pixel across."""


class Bands(NamedTuple):
    """Bands of screen rows, which workers share."""

    extents: NDArray[np.float32]
    """(S, `ribbon.COLUMNS`) of strands on the screen, from `ribbon.find_on_screen`."""
    rows: int
    """Height of a band. The picture does not depend on it."""
    workers: int


@parallel
def draw_strands(lines, depth_slope, bands, width, height, base, keys):
    """Draw all strands into a z-buffer.

    lines: `ScreenLines`; depth_slope: `DepthSlope`; bands: `Bands`; base: number added to a vertex index in the
    key; keys (height * width,) uint64, changed. One worker draws a band; worker i draws each band i + k · workers, so
    that crowded bands, which are neighbours, go to different workers.
    """
    for task in prange(bands.workers):
        steps = Steps(
            np.empty(PART, np.int32), np.empty(PART, np.int32), np.empty(PART, np.int32), np.empty(PART, np.int32),
            np.empty(PART, np.int64), np.empty(PART, np.int64), np.empty(PART, np.float32), np.empty(PART, np.float32),
        )  # fmt: skip
        for top in range(np.int64(task) * bands.rows, height, bands.workers * bands.rows):
            window = Window(top, min(top + bands.rows, height), width)
            draw_band(lines, lines.widths, depth_slope, bands.extents, window, base, steps, keys)


@device
def draw_band(lines, widths, depth_slope, extents, window, base, steps, keys):
    """Draw the strands in a `Window`; widths: of the lines; extents: of `Bands`; steps: `Steps` to work in; else as
    `draw_strands`."""
    above, below = np.float32(window.top), np.float32(window.bottom)
    for s in range(extents.shape[0]):
        if not (extents[s, LEAST_Y] < below and extents[s, GREATEST_Y] >= above):
            continue
        begin, end = lines.first[s], lines.first[s + 1]
        if widths is None:
            draw_lines(lines.screen, begin, end, window, base, steps, keys)
        else:
            draw_ribbons(lines.screen, widths, begin, end, depth_slope, window, base, keys)


@device
def draw_ribbons(screen, widths, begin, end, depth_slope, window, base, keys):
    """Draw the segments of the strand begin … end − 1 into the rows of a `Window`."""
    above = np.float32(window.top)
    below = np.float32(window.bottom)
    for v in range(begin + 1, end):
        if screen[v - 1, 2] <= ZERO or screen[v, 2] <= ZERO:
            continue
        w0 = max(widths[v - 1], ONE)
        w1 = max(widths[v], ONE)
        w = max(w0, w1)
        y0, y1 = screen[v - 1, 1], screen[v, 1]
        if max(y0, y1) + w < above or min(y0, y1) - w >= below:
            continue
        draw_ribbon(screen, v, begin, end, w0, w1, depth_slope, window, np.uint64(base + v - 1), keys)


@device
def draw_ribbon(screen, v, begin, end, w0, w1, depth_slope, window, identity, keys):
    """Draw the segment from vertex v − 1 to v of the strand begin … end − 1 into the rows of a `Window`.

    It is w0 >= 1 to w1 >= 1 pixels wide and covers each pixel whose centre is in its ribbon. Joints are mitred
    (`mitre`), a strand's ends are square, and joints too sharp for a mitre have round caps. The depth is that of
    the round side toward the eye, or of the axis if the strand is no wider than a pixel."""
    top, bottom, width = window
    if max(abs(screen[v, 0] - screen[v - 1, 0]), abs(screen[v, 1] - screen[v - 1, 1])) < TINY:
        return
    dx, dy, per = direction(screen, v)
    flat = abs(dx) >= abs(dy)
    joint0 = mitre(screen, v - 2, begin, end, dx, dy, HALF * w0, per)
    joint1 = mitre(screen, v, begin, end, dx, dy, HALF * w1, per)
    ribbon = make_ribbon(screen, v, w0, w1, flat, (dx, dy, per), joint0, joint1)
    # a cap is round where there is a neighbour without a mitre, but not one straight on
    round0 = v - 2 >= begin and screen[v - 2, 2] > ZERO and ribbon.ma0 == ribbon.da and ribbon.mb0 == ribbon.db
    round1 = v + 1 < end and screen[v + 1, 2] > ZERO and ribbon.ma1 == ribbon.da and ribbon.mb1 == ribbon.db
    round0 = round0 and turns(screen, v - 1, dx, dy)
    round1 = round1 and turns(screen, v + 1, dx, dy)
    reach0 = reach(w0, ribbon.ma0, ribbon.mb0, ribbon.da, ribbon.db, round0)
    reach1 = reach(w1, ribbon.ma1, ribbon.mb1, ribbon.da, ribbon.db, round1)
    low = np.ceil(min(ribbon.a0 - reach0, ribbon.a1 - reach1) - HALF)
    high = np.floor(max(ribbon.a0 + reach0, ribbon.a1 + reach1) - HALF) + ONE
    a_low, a_high, b_low, b_high = (0, width, top, bottom) if flat else (top, bottom, 0, width)
    along, across = (1, width) if flat else (width, 1)
    sides = Sides(round0, round1, w0, w1, np.float32(b_low), np.float32(b_high), along, across)
    for c in range(np.int64(max(low, np.float32(a_low))), np.int64(min(high, np.float32(a_high)))):
        draw_across(ribbon, sides, c, depth_slope, identity, keys)


@device
def turns(screen, v, dx, dy):
    """Return whether the segment from vertex v − 1 to v has another direction than the unit vector (dx, dy)."""
    ex, ey = screen[v, 0] - screen[v - 1, 0], screen[v, 1] - screen[v - 1, 1]
    return ex * dx + ey * dy <= (ONE - CLOSE) * math.sqrt(ex * ex + ey * ey)


@inlined
def draw_across(ribbon, sides, c, depth_slope, identity, keys):
    """Draw the samples of a ribbon in column number c of the picture, or in row number c if the ribbon follows y."""
    per = ONE / (ribbon.a1 - ribbon.a0)
    tall = HALF / abs(ribbon.da)
    lean = ribbon.db * ribbon.per_length  # change of t at the nearest point of the axis, for each pixel across
    centre = np.float32(c) + HALF
    past = centre - ribbon.a0
    left = centre - ribbon.a1
    t, broad, middle = cross_section(ribbon, per, ribbon.db / ribbon.da, past)
    forward = tilt = ZERO
    if max(sides.w0, sides.w1) > ONE:
        forward, tilt = offsets_across(ribbon, t, broad, centre, middle, depth_slope)
    half = tall * broad
    low = np.int64(max(np.ceil(middle - half - HALF), sides.low))
    high = np.int64(min(np.ceil(middle + half - HALF), sides.high))
    for row in range(low, high):
        b = np.float32(row) + HALF
        off = b - middle
        b0 = b - ribbon.b0
        b1 = b - ribbon.b1
        if past * ribbon.ma0 + b0 * ribbon.mb0 < ZERO and not (sides.round0 and in_cap(past, b0, sides.w0)):
            continue
        if left * ribbon.ma1 + b1 * ribbon.mb1 >= ZERO and not (sides.round1 and in_cap(left, b1, sides.w1)):
            continue
        t = min(max(past * per + lean * off, ZERO), ONE)
        aside = off / half
        near = ribbon.q0 + ribbon.rise * t + tilt * aside + forward * math.sqrt(max(ONE - aside * aside, ZERO))
        deposit(near, identity, np.uint64(c * sides.along + row * sides.across), keys)


@inlined
def reach(width, ma, mb, da, db, is_round):
    """Return the distance along a that a segment with the direction (da, db) extends beyond an end whose joint has the
    normal (ma, mb)."""
    return HALF * width * (ONE if is_round else abs(mb) / (ma * da + mb * db))


@device
def in_cap(x, y, wide):
    """Return whether (x, y), relative to a segment's end, is in its round cap."""
    return x * x + y * y <= HALF * HALF * wide * wide
