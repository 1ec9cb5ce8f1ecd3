"""Pieces of strands that are wide: bands cut at mitred joints, so that a bend shows no notch.

Within a pixel the band is exact; what lies beyond an end is taken off by how far the pixel's middle is past the joint's
line, and the next piece takes just that. The band's depth is that of a strand's round side toward the eye, or strands
that touch would be seen in the wrong order.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device
from ...geometry.kernels.joints import mitre
from ...zbuffer.kernels.raster import front
from .tiles import NUMBERS, PIXEL_BITS, ROW_BITS, fixed

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
FLAT = np.float32(1 / 16)
"""A slope of less is drawn as that: single precision needs it, and nobody sees it."""
FAINT = np.float32(1e-5)
"""Share of a cell that is not worth a fragment."""
OPAQUE = np.float32(1 - 1 / 512)
"""Opacity behind which nothing matters, as in `composite`."""
TINY = np.float32(1e-30)


@device
def ribbon(strands, widths, v, begin, end, target, m):
    """Add what the segment from vertex v − 1 to v of the strand begin … end − 1 covers to the m fragments found before;
    returns how many there are then.

    strands: `fragments.Strands`; widths: theirs; target: see `cells.Target`. Where the segment hides all that is
    behind it, the pixel's occlusion depth comes forward to it: of a thousand wide strands in a pixel, few are in front
    of all before them.
    """
    screen = strands.screen
    lit_past = (v - 1 - begin) & (strands.stride - 1)  # how many vertices v − 1 is past a lit one
    x0 = screen[v - 1, 0]
    y0 = screen[v - 1, 1]
    x1 = screen[v, 0]
    y1 = screen[v, 1]
    w0 = ONE if widths is None else widths[v - 1]
    w1 = ONE if widths is None else widths[v]
    dx = x1 - x0
    dy = y1 - y0
    flat = abs(dx) >= abs(dy)
    size = ONE / math.sqrt(dx * dx + dy * dy)
    dx *= size
    dy *= size
    mx0, my0 = mitre(screen, v - 2, begin, end, dx, dy, HALF * w0, size)
    mx1, my1 = mitre(screen, v, begin, end, dx, dy, HALF * w1, size)
    reach0 = HALF * w0 / (mx0 * dx + my0 * dy)
    reach1 = HALF * w1 / (mx1 * dx + my1 * dy)
    # the box of the four corners, and half a pixel about it
    west = min(x0 - reach0 * abs(my0), x1 - reach1 * abs(my1)) - HALF
    east = max(x0 + reach0 * abs(my0), x1 + reach1 * abs(my1)) + HALF
    above = min(y0 - reach0 * abs(mx0), y1 - reach1 * abs(mx1)) - HALF
    under = max(y0 + reach0 * abs(mx0), y1 + reach1 * abs(mx1)) + HALF
    x_low = np.int64(math.floor(max(west, np.float32(target.left))))
    x_high = np.int64(math.ceil(min(east, np.float32(target.right))))
    y_low = np.int64(math.floor(max(above, np.float32(target.top))))
    y_high = np.int64(math.ceil(min(under, np.float32(target.bottom))))
    u0 = x0 if flat else y0
    v0 = y0 if flat else x0
    per = ONE / (x1 - x0 if flat else y1 - y0)
    slope = (y1 - y0 if flat else x1 - x0) * per
    spread = max(abs(slope), FLAT)
    narrow = ONE / spread
    square = ONE + slope * slope
    tall = HALF * math.sqrt(square)
    # how much further along the piece the nearest point of its middle lies, for each pixel aside
    lean = slope / square * per
    q0 = screen[v - 1, 2]
    rise = screen[v, 2] - q0
    steep = rise * min(size, TWO / max(w0, w1))  # no further than its piece reaches
    turn = ONE if (dx if flat else -dy) > ZERO else -ONE  # whether rows go the way of (−dy, dx)
    cell_low = x_low if flat else y_low
    cell_high = (x_high if flat else y_high) if x_low < x_high and y_low < y_high else cell_low
    row_low = y_low if flat else x_low
    row_high = y_high if flat else x_high
    inside0 = ONE / (abs(mx0) + abs(my0))
    inside1 = ONE / (abs(mx1) + abs(my1))
    room = np.int64(target.found.shape[0] // NUMBERS - 1)
    for c in range(cell_low, cell_high):
        past = np.float32(c) + HALF - u0
        t = min(max(past * per, ZERO), ONE)
        h = tall * (w0 + t * (w1 - w0))
        over = ONE / max(h, TINY)
        middle = v0 + slope * past
        at_x = u0 + past if flat else middle
        at_y = middle if flat else u0 + past
        half = HALF * (w0 + t * (w1 - w0))
        forward, tilt = front(q0 + rise * t, half, steep, at_x, at_y, dx, dy, strands.depth_slope)
        tilt *= turn
        first = max(np.int64(math.floor(max(middle - h - spread, np.float32(row_low)))), row_low)
        stop = min(np.int64(math.ceil(min(middle + h + spread, np.float32(row_high)))), row_high)
        for row in range(first, stop):
            x = c if flat else row
            y = row if flat else c
            pixel = (y - target.top) << ROW_BITS | (x - target.left)
            rest = middle - np.float32(row)
            # of what the pixel shows of the width
            off = HALF * (min(max(-rest, -h), h) + min(max(ONE - rest, -h), h))
            t = min(max(past * per + lean * off, ZERO), ONE)
            off *= over
            q = q0 + rise * t + tilt * off + forward * math.sqrt(max(ONE - off * off, ZERO))
            if not q >= target.occlusion_depth[pixel]:
                continue
            cover = edge(rest + h, spread, narrow) - edge(rest - h, spread, narrow)
            px = np.float32(x) + HALF
            py = np.float32(y) + HALF
            entered = min(max(((px - x0) * mx0 + (py - y0) * my0) * inside0 + HALF, ZERO), ONE)
            left_ = min(max(((px - x1) * mx1 + (py - y1) * my1) * inside1 + HALF, ZERO), ONE)
            cover *= entered - left_
            if cover > FAINT:
                alpha = min(cover, ONE) * strands.opacity
                if alpha > OPAQUE:
                    target.occlusion_depth[pixel] = q
                o = min(m, room) * NUMBERS
                target.found[o] = np.float32(q).view(np.int32)
                target.found[o + 1] = np.float32(alpha).view(np.int32)
                target.found[o + 2] = v - 1
                target.found[o + 3] = fixed(t, lit_past, target.place_bits) << PIXEL_BITS | pixel
                target.counts[pixel] += 1
                m += 1
    return m


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
