"""Rasterisation of lines and ribbons into a z-buffer that holds, for each pixel, the visible segment.

A pixel holds one 64-bit key: the depth number, complemented so that nearer is smaller, above the index of the
segment's first vertex. The smallest key wins, and equal depths go to the lower index, so neither the order of drawing
nor the number of threads can change a picture. Colours are computed afterwards, for visible segments alone.

A line draws one sample a pixel along its longer axis, where that axis crosses the pixel's centre:

        .   .   .   .            a polyline's joints are drawn once,
      x---o . | .   .            because each segment covers the half-
        .   o---o---x            open range of centres between its ends
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....jit import device, inlined, parallel, prange
from ...common.kernels.keys import LOW, SHIFT
from ...geometry.kernels.ribbon import cross_section, direction, measure_ribbon, offsets_across, round_depth

HALF = np.float32(0.5)
ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-6)
"""Pixels. A shorter segment draws nothing."""
POINT = 24
"""Bits after the point of fixed-point positions."""
FIXED = np.float32(2.0**POINT)


class Window(NamedTuple):
    """The rows top <= y < bottom of a picture."""

    top: int
    bottom: int
    width: int
    """Of the picture, pixels."""


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


@parallel
def draw_strands(lines, depth_slope, bands_, width, height, base, keys):
    """Draw all strands into a z-buffer.

    lines: `ScreenLines`; depth_slope: `DepthSlope`; bands_: `bands.Bands`; base: number added to a vertex index in the
    key; keys (height * width,) uint64, changed. One worker draws a band; worker i draws each band i + k · workers, so
    that crowded bands, which are neighbours, go to different workers.
    """
    for task in prange(bands_.workers):
        for b in range(task, bands_.begin.shape[0] - 1, bands_.workers):
            top = b * bands_.rows
            window = Window(top, min(top + bands_.rows, height), width)
            draw_band(lines, lines.widths, depth_slope, bands_, b, window, base, keys)


@device
def draw_band(lines, widths, depth_slope, bands_, b, window, base, keys):
    """Draw the strands of band number `b`, whose rows are the window; widths: of the lines; else as `draw_strands`."""
    first, screen = lines.first, lines.screen
    members, begin = bands_.members, bands_.begin
    above = np.float32(window.top)
    below = np.float32(window.bottom)
    for m in range(begin[b], begin[b + 1]):
        s = members[m]
        a = first[s]
        x1 = screen[a, 0]
        y1 = screen[a, 1]
        q1 = screen[a, 2]
        for v in range(a + 1, first[s + 1]):
            x0 = x1
            y0 = y1
            q0 = q1
            x1 = screen[v, 0]
            y1 = screen[v, 1]
            q1 = screen[v, 2]
            if q0 <= ZERO or q1 <= ZERO:
                continue
            if widths is None:
                if max(y0, y1) < above or min(y0, y1) >= below:
                    continue
                draw_line(x0, y0, q0, x1, y1, q1, window, np.uint64(base + v - 1), keys)
            else:
                w0 = max(widths[v - 1], ONE)
                w1 = max(widths[v], ONE)
                w = max(w0, w1)
                if max(y0, y1) + w < above or min(y0, y1) - w >= below:
                    continue
                draw_ribbon(screen, v, a, first[s + 1], w0, w1, depth_slope, window, np.uint64(base + v - 1), keys)


@device
def draw_line(x0, y0, q0, x1, y1, q1, window, identity, keys):
    """Draw one segment into the rows of a `Window`.

    x, y: pixels; q: depth number; identity: low half of the key. The longer axis, and the end that comes first along
    it, are chosen without branches, which could not be predicted. Positions across the longer axis are in fixed point
    and step from the first centre on the screen, so that they do not depend on the band.
    """
    top, bottom, width = window
    wide = abs(x1 - x0) >= abs(y1 - y0)
    a0 = x0 if wide else y0
    b0 = y0 if wide else x0
    a1 = x1 if wide else y1
    b1 = y1 if wide else x1
    back = a1 < a0
    first = a1 if back else a0
    last = a0 if back else a1
    across = b1 if back else b0
    q = q1 if back else q0
    begin = max(np.ceil(first - HALF), ZERO)
    high = np.int64(min(np.ceil(last - HALF), np.float32(width if wide else bottom)))
    low = max(np.int64(begin), 0 if wide else top)
    if low >= high:
        return
    per = ONE / (a1 - a0)
    slope = (b1 - b0) * per
    rise = (q1 - q0) * per
    at = begin + HALF - first
    past = low - np.int64(begin)
    step = np.int64(slope * FIXED)
    b = np.int64((across + slope * at) * FIXED) + past * step
    q += rise * at
    along = 1 if wide else width
    over = width if wide else 1
    least = top if wide else 0
    most = (bottom if wide else width) - least
    at_a = low * along
    for k in range(past, past + high - low):
        row = b >> POINT
        if np.uint64(row - least) < np.uint64(most):
            deposit(q + rise * np.float32(k), identity, np.uint64(at_a + row * over), keys)
        at_a += along
        b += step


@device
def draw_ribbon(screen, v, begin, end, w0, w1, depth_slope, window, identity, keys):
    """Draw the segment from vertex v − 1 to v of the strand begin … end − 1 into the rows of a `Window`.

    It is w0 >= 1 to w1 >= 1 pixels wide and covers each pixel whose centre is in its ribbon. Joints are mitred
    (`joints.mitre`), a strand's ends are square, and joints too sharp for a mitre have round caps. The depth is that of
    the round side toward the eye, or of the axis if the strand is no wider than a pixel."""
    top, bottom, width = window
    if max(abs(screen[v, 0] - screen[v - 1, 0]), abs(screen[v, 1] - screen[v - 1, 1])) < TINY:
        return
    dx, dy, _ = direction(screen, v)
    flat = abs(dx) >= abs(dy)
    ribbon = measure_ribbon(screen, v, begin, end, w0, w1, flat)
    # a cap is round where there is a neighbour without a mitre
    round0 = v - 2 >= begin and screen[v - 2, 2] > ZERO and ribbon.ma0 == ribbon.da and ribbon.mb0 == ribbon.db
    round1 = v + 1 < end and screen[v + 1, 2] > ZERO and ribbon.ma1 == ribbon.da and ribbon.mb1 == ribbon.db
    reach0 = reach(w0, ribbon.ma0, ribbon.mb0, ribbon.da, ribbon.db, round0)
    reach1 = reach(w1, ribbon.ma1, ribbon.mb1, ribbon.da, ribbon.db, round1)
    low = np.ceil(min(ribbon.a0 - reach0, ribbon.a1 - reach1) - HALF)
    high = np.floor(max(ribbon.a0 + reach0, ribbon.a1 + reach1) - HALF) + ONE
    a_low, a_high, b_low, b_high = (0, width, top, bottom) if flat else (top, bottom, 0, width)
    along, across = (1, width) if flat else (width, 1)
    sides = Sides(round0, round1, w0, w1, np.float32(b_low), np.float32(b_high), along, across)
    for c in range(np.int64(max(low, np.float32(a_low))), np.int64(min(high, np.float32(a_high)))):
        draw_across(ribbon, sides, c, depth_slope, identity, keys)


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
        near = round_depth(ribbon, t, off / half, forward, tilt)
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


@device
def deposit(q, identity, pixel, keys):
    """Keep the nearer of a pixel's key and this one."""
    # rounding may make q negative, whose bits would count as near
    key = ((LOW - np.uint64(np.float32(max(q, ZERO)).view(np.uint32))) << SHIFT) | identity
    keys[pixel] = min(key, keys[pixel])  # an unconditional store, since a branch could not be predicted
