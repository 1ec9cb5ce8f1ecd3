"""Lines into a z-buffer, without colours: which segment is seen in each pixel.

A pixel holds one 64-bit key: the inverse depth, complemented so that nearer is smaller, above the index of the
segment's first vertex. The smallest key wins, and equal depths go to the lower index, so neither the order of drawing
nor the number of threads can change a picture. What is not seen is never shaded.

A line takes one sample a pixel along its longer axis, where that axis crosses the pixel's centre:

        .   .   .   .            a polyline's joints are drawn once,
      x---o . | .   .            because each piece covers the half-open
        .   o---o---x            range of centres between its ends
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....jit import device, parallel, prange
from ...common.kernels.keys import LOW, SHIFT
from ...geometry.kernels.joints import mitre

HALF = np.float32(0.5)
ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
TINY = np.float32(1e-6)
"""Pixels. What is shorter is a point, and draws nothing."""
POINT = 24
FIXED = np.float32(2.0**POINT)


class Window(NamedTuple):
    """The rows top <= y < bottom of a picture of this width."""

    top: int
    bottom: int
    width: int


@parallel
def visible(lines, depth_slope, bands_, width, height, base, keys):
    """Draw lines.

    lines: `ScreenLines`; depth_slope: `DepthSlope`; bands_: `bands.Bands`; base: number added to a vertex index in the
    key; keys (height * width,) uint64, drawn into. Each band has one owner; the workers take them in turn, so that busy
    bands are shared out.
    """
    for task in prange(bands_.workers):
        for b in range(task, bands_.begin.shape[0] - 1, bands_.workers):
            top = b * bands_.rows
            window = Window(top, min(top + bands_.rows, height), width)
            band(lines, lines.widths, depth_slope, bands_, b, window, base, keys)


@device
def band(lines, widths, depth_slope, bands_, b, window, base, keys):
    """All that `visible` does in band number `b`, which is the rows of the window; widths: those of the lines."""
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
                line(x0, y0, q0, x1, y1, q1, window, np.uint64(base + v - 1), keys)
            else:
                w0 = max(widths[v - 1], ONE)
                w1 = max(widths[v], ONE)
                w = max(w0, w1)
                if max(y0, y1) + w < above or min(y0, y1) - w >= below:
                    continue
                ribbon(screen, v, a, first[s + 1], w0, w1, depth_slope, window, np.uint64(base + v - 1), keys)


@device
def line(x0, y0, q0, x1, y1, q1, window, identity, keys):
    """Draw one segment into the rows of a `Window`.

    Which axis is longer, and which end comes first along it, is as good as random: both are chosen by selects, so that
    there is one loop and no branch to be guessed. Positions across the longer axis step in fixed point, 24 bits behind
    the point, whole steps from the first centre on the screen, so that the band's place does not matter.
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
def ribbon(screen, v, begin, end, w0, w1, depth_slope, window, identity, keys):
    """Draw the segment from vertex v − 1 to v of the strand begin … end − 1, w0 to w1 >= 1 pixels wide, into the rows
    of a `Window`: a sample for each centre that its band covers, which ends where the next segment's begins
    (`joints.mitre`), straight across at the strand's ends, and round where the strand turns too sharply for either.
    Depth is that of a strand's round side toward the eye; a strand that is no wider than a pixel is flat."""
    top, bottom, width = window
    x0, y0, q0 = screen[v - 1, 0], screen[v - 1, 1], screen[v - 1, 2]
    x1, y1, q1 = screen[v, 0], screen[v, 1], screen[v, 2]
    dx = x1 - x0
    dy = y1 - y0
    if max(abs(dx), abs(dy)) < TINY:
        return
    per = ONE / np.sqrt(dx * dx + dy * dy)
    dx *= per
    dy *= per
    mx0, my0 = mitre(screen, v - 2, begin, end, dx, dy, HALF * w0, per)
    mx1, my1 = mitre(screen, v, begin, end, dx, dy, HALF * w1, per)
    # a: along the axis that the piece follows more, b: across it
    flat = abs(dx) >= abs(dy)
    a0, b0, ma0, mb0 = (x0, y0, mx0, my0) if flat else (y0, x0, my0, mx0)
    a1, b1, ma1, mb1 = (x1, y1, mx1, my1) if flat else (y1, x1, my1, mx1)
    da, db = (dx, dy) if flat else (dy, dx)
    round0 = v - 2 >= begin and screen[v - 2, 2] > ZERO and mx0 == dx and my0 == dy
    round1 = v + 1 < end and screen[v + 1, 2] > ZERO and mx1 == dx and my1 == dy
    # how far it reaches along it beyond its ends
    reach0 = HALF * w0 * (ONE if round0 else abs(mb0) / (mx0 * dx + my0 * dy))
    reach1 = HALF * w1 * (ONE if round1 else abs(mb1) / (mx1 * dx + my1 * dy))
    low = min(a0 - reach0, a1 - reach1) - HALF
    high = max(a0 + reach0, a1 + reach1) - HALF
    # whole numbers along and across, and what a step of each is in `keys`
    a_low = np.int64(max(np.ceil(low), ZERO if flat else np.float32(top)))
    a_high = np.int64(min(np.floor(high) + ONE, np.float32(width if flat else bottom)))
    least = np.float32(top if flat else 0)
    most = np.float32(bottom if flat else width)
    one = 1 if flat else width
    aside = width if flat else 1
    over = ONE / (a1 - a0)
    slope = db / da
    rise = q1 - q0
    tall = HALF / abs(da)
    # how much further along the piece the nearest point of its middle lies, for each pixel aside
    lean = db * per
    w = max(w0, w1)
    steep = rise * min(per, TWO / w)  # no further than its piece reaches
    turn = ONE if (dx if flat else -dy) > ZERO else -ONE  # whether rows go the way of (−dy, dx)
    for c in range(a_low, a_high):
        past = np.float32(c) + HALF - a0
        t = min(max(past * over, ZERO), ONE)
        broad = w0 + t * (w1 - w0)
        half = tall * broad
        middle = b0 + slope * past
        forward = tilt = ZERO
        if w > ONE:
            centre = np.float32(c) + HALF
            x = centre if flat else middle
            y = middle if flat else centre
            forward, tilt = front(q0 + rise * t, HALF * broad, steep, x, y, dx, dy, depth_slope)
            tilt *= turn
        b_low = np.int64(max(np.ceil(middle - half - HALF), least))
        b_high = np.int64(min(np.ceil(middle + half - HALF), most))
        for row in range(b_low, b_high):
            b = np.float32(row) + HALF
            off = b - middle
            if past * ma0 + (b - b0) * mb0 < ZERO and not (round0 and near_by(past, b - b0, w0)):
                continue
            left = np.float32(c) + HALF - a1
            if left * ma1 + (b - b1) * mb1 >= ZERO and not (round1 and near_by(left, b - b1, w1)):
                continue
            t = min(max(past * over + lean * off, ZERO), ONE)
            h = off / half
            near = q0 + rise * t + tilt * h + forward * np.sqrt(max(ONE - h * h, ZERO))
            deposit(near, identity, np.uint64(c * one + row * aside), keys)


@device
def near_by(x, y, wide):
    """Whether a place is within half a width."""
    return x * x + y * y <= HALF * HALF * wide * wide


@device
def front(q, half, steep, x, y, dx, dy, depth_slope):
    """By how much the depth number on the side toward the eye of a strand, `half` a width in pixels, exceeds that in
    its middle: in front of the middle, and what is added at the edge toward (−dy, dx) and taken off at the other one;
    0 where strands are flat.

    q: in the middle, which the pixel (x, y) shows, where it grows by `steep` a pixel along the strand's direction (dx,
    dy), of length 1; depth_slope: `DepthSlope`. A ray (u, v, 1) that passes a slanted cylinder aside of the
    view's axis meets it further in front of its middle, and not at the same depth on both sides. With p and w, what of
    (u, v) lies along the strand and across it, and the strand's way E − g (u, v, 1), E = (dx, dy, 0), that is

        q half √(1 − 2 g p + g² (1 + p² + w²)) / (1 + w²)   and   q half w (1 − g p) / (1 + w²),

    the first terms in powers of half of the greater root of |(z (u, v, 1) − P) × E| = radius in 1 / z.
    """
    per = depth_slope.per_depth * q + depth_slope.constant
    if per <= ZERO:
        return ZERO, ZERO
    u = (x - depth_slope.axis_x) * depth_slope.per_depth
    v = (y - depth_slope.axis_y) * depth_slope.per_depth
    p = u * dx + v * dy
    w = v * dx - u * dy
    g = steep / per
    slant = ONE - g * p
    scale = half * per / (ONE + w * w)
    return scale * np.sqrt(slant * slant + g * g * (ONE + w * w)), scale * w * slant


@device
def deposit(q, identity, pixel, keys):
    """Keep the nearer of a pixel's key and this one. Rounding may take q below zero, whose bits would pass for near."""
    key = ((LOW - np.uint64(np.float32(max(q, ZERO)).view(np.uint32))) << SHIFT) | identity
    keys[pixel] = min(key, keys[pixel])  # a store always: which is nearer cannot be predicted
