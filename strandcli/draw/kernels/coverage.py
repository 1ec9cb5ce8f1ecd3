"""Strands as fragments: how much of each pixel's box a piece of a strand covers, exactly, however thin it is.

A piece is a band about its middle line. Seen along the axis that the piece follows more, a pixel is a cell: a strip one
pixel long that the band crosses, in the figure from left to right with the slope s. How far the band lies above the
rows' borders within the cell is a box (the band's height, 2 h) averaged over another (the rise within the cell, s), so
that the share of its area under a border is a trapezoid's integral:

    row + 1 ______________                          ____
                       _.-'   middle line          /    \\     what of the band's area lies at which height
                  _.-'                        ____/      \\____
    row     ___-'_________                       |a  b
                                                 a = h + s / 2, b = |h − s / 2|

Shares of neighbouring rows are differences of that integral, so they add up to the band's area exactly. A band thinner
than an eighth of a pixel is drawn that wide and as much paler, and a slope of less than 1/16 as that: single precision
needs it, and nobody sees it.

Thin pieces of one strand that follow the same axis the same way are a run. Each cell of a run is drawn once, by the
piece that leaves it, its ends by what they cover of their cells: no joint is counted twice, and the area of a strand is
its length times its width. Pieces wider than `WIDE` are cut at mitred joints instead, so that a bend shows no notch.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import function

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
WIDE = np.float32(0.7)
"""Pixels. Narrower than that, a cell of a piece touches three rows at the most."""
THIN = np.float32(1 / 16)
FLAT = np.float32(1 / 16)
FAINT = np.float32(1e-5)
"""Share of a cell that is not worth a fragment."""
POINT = np.float32(1e-6)
"""Pixels. What is shorter is a point, and draws nothing."""
TINY = np.float32(1e-30)
LOW = np.uint64(0xFFFFFFFF)
SHIFT = np.uint64(32)


@function
def walk(first, screen, widths, opacity, members, m, beyond, top, bottom, width, limit, pixels, stream, most):
    """Append the fragments of strands to a stream, strand after strand.

    first (S + 1,) int64; screen (V, 3) float32 as from `project.points`; widths (V,) float32 pixels, or None for lines
    one pixel wide; opacity: of the material; members (M,) int32: strands, of which those from place `m` to `beyond` are
    taken; rows top <= y < bottom of the picture; limit (height * width,) uint64: z-buffer of the solids, or None.
    pixels (F + 1,) uint32, counted from the first in row `top`; stream (F + 1, 4) uint32: bits of the depth number,
    index of the piece's first vertex, bits of the opacity and of the place along the piece in [0, 1].
    Stops before the first strand that finds more than `most` fragments there. Returns its place in members, and how
    many fragments there are: what is more than F is counted, not kept.
    """
    n = np.int64(0)
    while m < beyond and n <= most:
        s = members[m]
        m += 1
        a = first[s]
        end = first[s + 1]
        run = 0
        start = ZERO
        last = a
        x1 = screen[a, 0]
        y1 = screen[a, 1]
        q1 = screen[a, 2]
        for v in range(a + 1, end):
            x0 = x1
            y0 = y1
            q0 = q1
            x1 = screen[v, 0]
            y1 = screen[v, 1]
            q1 = screen[v, 2]
            dx = x1 - x0
            dy = y1 - y0
            flat = abs(dx) >= abs(dy)
            du = dx if flat else dy
            way = 0
            if q0 > ZERO and q1 > ZERO:
                if abs(du) < POINT:
                    continue
                if widths is None or max(widths[v - 1], widths[v]) > WIDE:
                    n = ribbon(screen, widths, opacity, v, a, end, flat, top, bottom, width, limit, pixels, stream, n)
                else:
                    way = 1 if flat else 2
                    way = way if du > ZERO else -way
            if widths is None:
                continue
            if way != run:
                if run != 0:
                    n = close(screen, widths, opacity, last, run, start, top, bottom, width, limit, pixels, stream, n)
                run = way
                start = x0 if flat else y0
                start = start if way > 0 else -start
            if way != 0:
                last = v
                if max(y0, y1) + TWO >= np.float32(top) and min(y0, y1) - TWO < np.float32(bottom):
                    n = thin(
                        screen, widths, opacity, v, run, start, False, top, bottom, width, limit, pixels, stream, n
                    )
        if run != 0:
            n = close(screen, widths, opacity, last, run, start, top, bottom, width, limit, pixels, stream, n)
    return m, n


@function
def close(screen, widths, opacity, v, run, start, top, bottom, width, limit, pixels, stream, n):
    """The cell in which a run ends, with the piece from vertex v − 1 to v."""
    return thin(screen, widths, opacity, v, run, start, True, top, bottom, width, limit, pixels, stream, n)


@function
def thin(screen, widths, opacity, v, run, start, closing, top, bottom, width, limit, pixels, stream, n):
    """The cells that the piece from vertex v − 1 to v leaves behind, or, `closing`, the one that its run ends in.

    run: 1 along x, 2 along y, negative against the axis; start: where the run begins, in the direction of travel.
    """
    flat = abs(run) == 1
    sign = ONE if run > 0 else -ONE
    u0 = sign * (screen[v - 1, 0] if flat else screen[v - 1, 1])
    u1 = sign * (screen[v, 0] if flat else screen[v, 1])
    v0 = screen[v - 1, 1] if flat else screen[v - 1, 0]
    v1 = screen[v, 1] if flat else screen[v, 0]
    low = 0 if flat else top
    high = width if flat else bottom
    least = low if run > 0 else -high
    most = high if run > 0 else -low
    cell = whole(u0)
    stop = whole(u1)
    if closing:
        cell = stop
        stop += 1
    cell = max(cell, least)
    stop = min(stop, most)
    if cell >= stop:
        return n
    per = ONE / (u1 - u0)
    slope = (v1 - v0) * per
    q0 = screen[v - 1, 2]
    rise = screen[v, 2] - q0
    w0 = widths[v - 1]
    w1 = widths[v]
    stretch = math.sqrt(ONE + slope * slope)
    h = max(HALF * stretch * max(w0, w1), THIN)
    stretch *= opacity
    a, b, norm = trapezoid(h, abs(slope))
    # pixel = place + (column or row along) · along + across · over
    over = width if flat else 1
    along = 1 if flat else width
    place = 0 if run > 0 else -along
    along = along if run > 0 else -along
    least = top if flat else 0
    most = bottom if flat else width
    after_start = whole(start) + 1
    for c in range(cell, stop):
        begin = max(np.float32(c), start)
        length = (u1 if closing else np.float32(c + 1)) - begin
        past = begin + HALF * length - u0
        t = min(max(past * per, ZERO), ONE)
        q = q0 + rise * t
        middle = v0 + slope * past
        area = stretch * length * (w0 + t * (w1 - w0))
        if length < ONE:  # the ends of a run rise by less
            a, b, norm = trapezoid(h, abs(slope) * length)
        elif c == after_start:
            a, b, norm = trapezoid(h, abs(slope))
        row = whole(middle - a)
        at = place + c * along + row * over
        if limit is not None and least <= row and row + 2 < most:
            # what a solid hides it hides for a while, so that this branch is guessed right
            depth = np.float32(max(q, ZERO)).view(np.uint32)
            if (
                hidden(depth, limit, at)
                and hidden(depth, limit, at + over)
                and hidden(depth, limit, at + over + over)
            ):
                continue
        d = np.float32(row + 1) - middle
        one = below(d, a, b, norm)
        two = below(d + ONE, a, b, norm)
        i = np.uint32(v - 1)
        n = put(at, row, least, most, area, one, q, i, t, top * width, limit, pixels, stream, n)
        n = put(at + over, row + 1, least, most, area, two - one, q, i, t, top * width, limit, pixels, stream, n)
        if two < ONE:
            at += over + over
            n = put(at, row + 2, least, most, area, ONE - two, q, i, t, top * width, limit, pixels, stream, n)
    return n


@function
def trapezoid(h, rise):
    """Half the lower and half the upper side of a band's trapezoid, and the
    factor that makes its area one; h: half the band's height, rise: what it rises by within its cell."""
    spread = max(rise, FLAT)
    return h + HALF * spread, abs(h - HALF * spread), HALF * HALF / (h * spread)


@function
def whole(x):
    """The greatest whole number that is no greater than x: the library's is a call, for which registers are saved."""
    i = np.int64(x)
    return i - np.int64(np.float32(i) > x)


@function
def below(d, a, b, norm):
    """Share of a cell's band that lies no more than d above its middle."""
    e = abs(d)
    outer = max(a - e, ZERO)
    inner = max(b - e, ZERO)
    tail = (outer * outer - inner * inner) * norm
    return tail if d < ZERO else ONE - tail


@function
def put(at, row, least, most, area, share, q, identity, t, base, limit, pixels, stream, n):
    """Append a share of a cell's area where that is worth it and on the picture: written in any case and kept or not,
    because whether cannot be guessed."""
    kept = (share > FAINT) & (row >= least) & (row < most)
    return append(at if kept else base, kept, min(area * share, ONE), q, identity, t, base, limit, pixels, stream, n)


@function
def hidden(depth, limit, at):
    """Whether a solid stands before this depth, given as the bits of its number, in pixel `at`."""
    return np.uint64(depth) < LOW - (limit[np.uint64(at)] >> SHIFT)


@function
def append(at, kept, alpha, q, identity, t, base, limit, pixels, stream, n):
    """Append one fragment, unless a solid hides it. Returns how many there are then."""
    depth = np.float32(max(q, ZERO)).view(np.uint32)
    if limit is not None:
        kept &= not hidden(depth, limit, at)
    slot = np.uint64(min(n, np.int64(pixels.shape[0] - 1)))
    pixels[slot] = np.uint32(at - base)
    stream[slot, 0] = depth
    stream[slot, 1] = identity
    stream[slot, 2] = np.float32(alpha).view(np.uint32)
    stream[slot, 3] = np.float32(t).view(np.uint32)
    return n + np.int64(kept)


@function
def ribbon(screen, widths, opacity, v, a, end, flat, top, bottom, width, limit, pixels, stream, n):
    """The piece from vertex v − 1 to v where it is wide, between the mitres at its ends.

    Within a pixel the band is exact; what lies beyond an end is taken off by how far the pixel's middle is past the
    joint's line, and the next piece takes just that.
    """
    x0 = screen[v - 1, 0]
    y0 = screen[v - 1, 1]
    x1 = screen[v, 0]
    y1 = screen[v, 1]
    w0 = ONE if widths is None else widths[v - 1]
    w1 = ONE if widths is None else widths[v]
    dx = x1 - x0
    dy = y1 - y0
    size = ONE / math.sqrt(dx * dx + dy * dy)
    dx *= size
    dy *= size
    mx0, my0 = mitre(screen, v - 2, a, end, dx, dy, HALF * w0, size)
    mx1, my1 = mitre(screen, v, a, end, dx, dy, HALF * w1, size)
    reach0 = HALF * w0 / (mx0 * dx + my0 * dy)
    reach1 = HALF * w1 / (mx1 * dx + my1 * dy)
    # the box of the four corners, and half a pixel about it
    left = min(x0 - reach0 * abs(my0), x1 - reach1 * abs(my1)) - HALF
    right = max(x0 + reach0 * abs(my0), x1 + reach1 * abs(my1)) + HALF
    above = min(y0 - reach0 * abs(mx0), y1 - reach1 * abs(mx1)) - HALF
    under = max(y0 + reach0 * abs(mx0), y1 + reach1 * abs(mx1)) + HALF
    x_low = np.int64(math.floor(max(left, ZERO)))
    x_high = np.int64(math.ceil(min(right, np.float32(width))))
    y_low = np.int64(math.floor(max(above, np.float32(top))))
    y_high = np.int64(math.ceil(min(under, np.float32(bottom))))
    if x_low >= x_high or y_low >= y_high:
        return n
    u0 = x0 if flat else y0
    v0 = y0 if flat else x0
    per = ONE / (x1 - x0 if flat else y1 - y0)
    slope = (y1 - y0 if flat else x1 - x0) * per
    spread = max(abs(slope), FLAT)
    narrow = ONE / spread
    tall = HALF * math.sqrt(ONE + slope * slope)
    q0 = screen[v - 1, 2]
    rise = screen[v, 2] - q0
    cell_low = x_low if flat else y_low
    cell_high = x_high if flat else y_high
    row_low = y_low if flat else x_low
    row_high = y_high if flat else x_high
    along = 1 if flat else width
    over = width if flat else 1
    inside0 = ONE / (abs(mx0) + abs(my0))
    inside1 = ONE / (abs(mx1) + abs(my1))
    for c in range(cell_low, cell_high):
        past = np.float32(c) + HALF - u0
        t = min(max(past * per, ZERO), ONE)
        q = q0 + rise * t
        h = tall * (w0 + t * (w1 - w0))
        middle = v0 + slope * past
        begin = max(np.int64(math.floor(max(middle - h - spread, np.float32(row_low)))), row_low)
        stop = min(np.int64(math.ceil(min(middle + h + spread, np.float32(row_high)))), row_high)
        for row in range(begin, stop):
            rest = middle - np.float32(row)
            cover = edge(rest + h, spread, narrow) - edge(rest - h, spread, narrow)
            if cover <= FAINT:
                continue
            x = (np.float32(c) if flat else np.float32(row)) + HALF
            y = (np.float32(row) if flat else np.float32(c)) + HALF
            entered = min(max(((x - x0) * mx0 + (y - y0) * my0) * inside0 + HALF, ZERO), ONE)
            left_ = min(max(((x - x1) * mx1 + (y - y1) * my1) * inside1 + HALF, ZERO), ONE)
            cover *= entered - left_
            if cover > FAINT:
                n = append(
                    c * along + row * over, True, min(cover, ONE) * opacity, q, np.uint32(v - 1), t,
                    top * width, limit, pixels, stream, n,
                )  # fmt: skip
    return n


@function
def mitre(screen, v, a, end, dx, dy, half, per):
    """Normal of the joint between a piece of direction d and its neighbour, the one from vertex v to v + 1: halfway
    between their directions. At a strand's end it is d itself, and where the strand turns by more than a right angle,
    or by so much that the joint's line, half the width long, would leave one of the two pieces at its other end.

    half: of the width at the joint; per: one over the piece's length.
    """
    if v < a or v + 1 >= end or screen[v, 2] <= ZERO or screen[v + 1, 2] <= ZERO:
        return dx, dy
    ex = screen[v + 1, 0] - screen[v, 0]
    ey = screen[v + 1, 1] - screen[v, 1]
    size = ONE / math.sqrt(max(ex * ex + ey * ey, TINY))
    cosine = (ex * dx + ey * dy) * size
    # tan² of half the angle; both pieces come to the same answer
    tangent = (ONE - cosine) / max(ONE + cosine, TINY)
    squat = half * max(size, per)
    if cosine <= ZERO or tangent * squat * squat > ONE:
        return dx, dy
    mx = ex * size + dx
    my = ey * size + dy
    size = ONE / math.sqrt(mx * mx + my * my)
    return mx * size, my * size


@function
def edge(height, spread, narrow):
    """How much of a pixel's column lies under an edge at this height above the row, averaged over the edge's rise."""
    height = min(max(height, -ONE), TWO)
    return (ramp(height + HALF * spread) - ramp(height - HALF * spread)) * narrow


@function
def ramp(x):
    """Integral of x clipped to [0, 1]."""
    inside = min(max(x, ZERO), ONE)
    return HALF * inside * inside + max(x - ONE, ZERO)
