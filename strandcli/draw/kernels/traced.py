"""Exact shadows of strands on strands: what of a strand's length other strands leave in the light.

Seen from the light a piece of a strand is a flat band, and a strand that is lit is a line. A band that crosses the line
in front of it takes a part of its length away, of which three pairs of linear inequalities tell the ends: within the
band's width, between the band's ends, nearer to the light than the line. No ray is cast and nothing is sampled; there
is only the union of those parts to be formed, and for that each piece is cut into `PARTS`. A part that is covered whole
stays so whatever else covers it; of what covers it in part the places are taken as independent.

Bands are listed in the square cells of a grid over the light's view that they touch, nearest first, as keys: the depth
number, complemented so that nearer is smaller, above the index of the piece's first vertex. A line is followed from
cell to cell. Within a cell the list ends for it where bands lie behind it, and the inequalities are one loop over the
bands, which becomes vector code.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import inlined, inner, parallel, prange

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
PARTS = np.int64(8)
"""Parts of a piece."""
PER = ONE / np.float32(PARTS)
DARK = np.float32(1 / 512)
"""What gets less light than this is not looked at any further."""
MOST = np.int64(32)
"""Pieces to each side of a vertex that its light is averaged over, at most."""
STRANDS = 32
"""Strands a task."""
LOW = np.int64(0xFFFFFFFF)
NEAREST = np.int64(0x7FFFFFFF)
"""No less than the bits of any number that is not negative."""
SHIFT = np.int64(32)
BATCH = 64
"""Bands that are held against a line at once."""
# Rows of numbers, one for each band of a cell: how far aside a point of the cell lies, in half widths; how far along,
# in lengths; the depth number at the band's beginning and how much it grows.
ASIDE_X, ASIDE_Y, ASIDE, ALONG_X, ALONG_Y, ALONG, DEPTH, GROWS = range(8)
ROWS = 8


@parallel
def list_bands(first, bands, members, begin, size, rows, workers, at, keys):
    """List in every cell the bands that touch it: how many there are, where `keys` is None, or else their keys.

    first (S + 1,) int64; bands (V, 4): of each vertex x and y in cells, the depth number of `project.points`, half the
    width in cells; members, begin, rows, workers: as in `shadow.fill`; at (size * size,) int64: counts, to be added to,
    or the place of each cell's next key; keys (K,) int64.
    """
    for task in prange(workers):
        for b in range(task, begin.shape[0] - 1, workers):
            top = b * rows
            bottom = min(top + rows, size)
            for m in range(begin[b], begin[b + 1]):
                s = members[m]
                for v in range(first[s], first[s + 1] - 1):
                    if bands[v, 2] > ZERO and bands[v + 1, 2] > ZERO:
                        list_one(bands, v, top, bottom, size, at, keys)


@inner
def list_one(bands, v, top, bottom, size, at, keys):
    """All that `list_bands` does with the piece after vertex v in the rows from `top` to before `bottom`."""
    x0 = bands[v, 0]
    y0 = bands[v, 1]
    x1 = bands[v + 1, 0]
    y1 = bands[v + 1, 1]
    half = max(bands[v, 3], bands[v + 1, 3])
    key = nearness(max(bands[v, 2], bands[v + 1, 2])) | v
    for row in range(whole(min(y0, y1) - half, top, bottom), whole(max(y0, y1) + half + ONE, top, bottom)):
        low, high = columns(x0, y0, x1, y1, half, row)
        for column in range(whole(low, 0, size), whole(high + ONE, 0, size)):
            cell = row * size + column
            if keys is not None:
                keys[at[cell]] = key
            at[cell] += 1


@inlined
def nearness(q):
    """The upper half of a key."""
    return (NEAREST - np.int64(np.float32(q).view(np.int32))) << SHIFT


@inlined
def whole(x, low, high):
    """The greatest whole number that is no greater than x, kept between two others."""
    return np.int64(min(max(math.floor(x), np.float32(low)), np.float32(high)))


@inlined
def columns(x0, y0, x1, y1, half, row):
    """From where to where a band reaches in a row of cells, or somewhat further."""
    begin = ZERO
    end = ONE
    rise = y1 - y0
    if rise != ZERO:
        a = (np.float32(row) - half - y0) / rise
        b = (np.float32(row) + ONE + half - y0) / rise
        begin = max(begin, min(a, b))
        end = min(end, max(a, b))
    a = x0 + begin * (x1 - x0)
    b = x0 + end * (x1 - x0)
    return min(a, b) - half, max(a, b) + half


@parallel
def order(begin, size, bands, keys, lines):
    """Sort the keys of each cell, and write down their bands as rows of numbers, relative to the cell's corner.

    begin (size * size + 1,) int64: where each cell's keys begin in keys, and an eighth of where its rows do in lines
    (8 K,) float32; bands (V, 4).
    """
    for row in prange(size):
        for column in range(size):
            cell = np.int64(row) * size + column
            i = begin[cell]
            n = begin[cell + 1] - i
            if n > 1:
                keys[i : i + n].sort()
            for k in range(n):
                equation(bands, keys[i + k] & LOW, np.float32(column), np.float32(row), lines, ROWS * i + k, n)


@inner
def equation(bands, v, column, row, lines, at, n):
    """Write down the band after vertex v, its rows' numbers from place `at` on, n apart."""
    gx = bands[v + 1, 0] - bands[v, 0]
    gy = bands[v + 1, 1] - bands[v, 1]
    px = column - bands[v, 0]
    py = row - bands[v, 1]
    square = gx * gx + gy * gy
    half = HALF * (bands[v, 3] + bands[v + 1, 3])
    seen = (square > TINY) & (half > ZERO)
    per = ONE / (math.sqrt(square) * half) if seen else ZERO
    lines[at + ASIDE_X * n] = -gy * per
    lines[at + ASIDE_Y * n] = gx * per
    lines[at + ASIDE * n] = gx * per * py - gy * per * px if seen else ONE + ONE
    per = ONE / square if seen else ZERO
    lines[at + ALONG_X * n] = gx * per
    lines[at + ALONG_Y * n] = gy * per
    lines[at + ALONG * n] = gx * per * px + gy * per * py
    lines[at + DEPTH * n] = bands[v, 2]
    lines[at + GROWS * n] = bands[v + 1, 2] - bands[v, 2]


@parallel
def visibility(
    first, world, marks, screen, stride, most, views, sizes, cells, begin, keys, lines, opacity, bias, apart, out
):
    """Share of a light that strands leave at marked vertices: the mean over the strand's length about each.

    first, world, stride: polylines and their lit vertices; marks (V,) uint8: lit vertices where it is wanted; screen
    (V, 3): where a camera sees the vertices, in samples; most: pieces of the longest polyline. Of each of the light's
    views, views (M, 26) and sizes (M,), cells (M,) tells where its cells begin in begin (C,), which tells where their
    keys begin; keys, lines: as `order` leaves them. Several views are the six sides of a cube. opacity of strands;
    bias: metres in front of which nothing is shaded; apart: pieces to each side which a piece is not shaded by; out
    (V,).

    The mean is weighted by a hat that reaches to the next lit vertices or over a sample of the picture, whichever is
    farther.
    """
    count = first.shape[0] - 1
    for task in prange((count + STRANDS - 1) // STRANDS):
        clear = np.empty((most + 1) * PARTS, np.float32)
        wanted = np.empty(most + 1, np.uint8)
        cuts = np.empty(2 * BATCH, np.float32)
        for s in range(task * STRANDS, min((task + 1) * STRANDS, count)):
            a = first[s]
            n = first[s + 1] - a - 1
            if not want(a, n, marks, screen, stride, wanted):
                continue
            for p in range(n):
                if wanted[p] == 0:
                    continue
                for k in range(p * PARTS, (p + 1) * PARTS):
                    clear[k] = ONE
                low = max(p - apart, 0) + a
                high = min(p + apart, n - 1) + a
                for one in range(views.shape[0]):
                    piece(
                        world, a + p, p * PARTS, views, one, sizes[one], cells[one], begin, keys, lines, low, high,
                        opacity, bias, cuts, clear,
                    )  # fmt: skip
            for v in range(0, n + 1, stride):
                if marks[a + v] != 0:
                    out[a + v] = mean(clear, v, n, reach(screen, a, v, n, stride))


@inner
def want(a, n, marks, screen, stride, wanted):
    """Flag the pieces that the marked vertices need; whether there are any."""
    wanted[:n] = 0
    found = False
    for v in range(0, n + 1, stride):
        if marks[a + v] != 0:
            far = reach(screen, a, v, n, stride)
            wanted[max(v - far, 0) : min(v + far, n)] = 1
            found = True
    return found


@inner
def reach(screen, a, v, n, stride):
    """How many pieces to each side of vertex v its light is averaged over."""
    p = a + min(v, max(n - 1, 0))
    if n == 0 or screen[p, 2] <= ZERO or screen[p + 1, 2] <= ZERO:
        return stride
    dx = screen[p + 1, 0] - screen[p, 0]
    dy = screen[p + 1, 1] - screen[p, 1]
    size = math.sqrt(dx * dx + dy * dy)
    return max(stride, np.int64(math.ceil(min(ONE / max(size, TINY), np.float32(MOST)))))


@inner
def mean(clear, v, n, far):
    """What of the light is left about vertex v of n pieces, weighted by a hat that reaches over `far` pieces."""
    total = ZERO
    weights = ZERO
    per = ONE / np.float32(far)
    for k in range(max(v - far, 0) * PARTS, min(v + far, n) * PARTS):
        weight = ONE - abs((np.float32(k) + HALF) * PER - np.float32(v)) * per
        total += weight * clear[k]
        weights += weight
    return total / weights if weights > ZERO else ONE


@inner
def piece(world, v, at, views, one, size, cells, begin, keys, lines, low, high, opacity, bias, cuts, clear):
    """Darken the parts of the piece after vertex v, from place `at` on, by what one view shows in front of them; not by
    the pieces after the vertices from `low` to `high`."""
    x0, y0, q0 = seen(world, v, views, one, bias)
    x1, y1, q1 = seen(world, v + 1, views, one, bias)
    if q0 <= ZERO or q1 <= ZERO:
        return
    dx = x1 - x0
    dy = y1 - y0
    dq = q1 - q0
    # of a cube's sides none sees what is another's
    edge = np.float32(1.5) if views.shape[0] > 1 else ZERO
    since, until = between(ZERO, ONE, x0 - edge, dx)
    since, until = between(since, until, np.float32(size) - edge - x0, -dx)
    since, until = between(since, until, y0 - edge, dy)
    since, until = between(since, until, np.float32(size) - edge - y0, -dy)
    if since >= until:
        return
    for row in range(whole(min(y0, y1), 0, size), whole(max(y0, y1) + ONE, 0, size)):
        left, right = columns(x0, y0, x1, y1, ZERO, row)
        above, under = between(since, until, y0 - np.float32(row), dy)
        above, under = between(above, under, np.float32(row + 1) - y0, -dy)
        for column in range(whole(left, 0, size), whole(right + ONE, 0, size)):
            a, b = between(above, under, x0 - np.float32(column), dx)
            a, b = between(a, b, np.float32(column + 1) - x0, -dx)
            cell = cells + row * size + column
            if a < b and begin[cell] < begin[cell + 1]:
                x = x0 - np.float32(column)
                y = y0 - np.float32(row)
                cross(
                    x + a * dx, y + a * dy, q0 + a * dq, x + b * dx, y + b * dy, q0 + b * dq, a, b, begin[cell],
                    begin[cell + 1], keys, lines, low, high, opacity, at, cuts, clear,
                )  # fmt: skip


@inlined
def seen(world, v, views, one, bias):
    """Where a view shows a vertex, in cells, and its depth number; 0 where it does not."""
    x = views[one, 0] * world[v, 0] + views[one, 1] * world[v, 1] + views[one, 2] * world[v, 2] + views[one, 3]
    y = views[one, 4] * world[v, 0] + views[one, 5] * world[v, 1] + views[one, 6] * world[v, 2] + views[one, 7]
    z = views[one, 8] * world[v, 0] + views[one, 9] * world[v, 1] + views[one, 10] * world[v, 2] + views[one, 11]
    if not z >= views[one, 14]:
        return ZERO, ZERO, ZERO
    near = max(z - bias, views[one, 14])
    if views[one, 12] > ZERO:
        scale = views[one, 13] / z
        q = ONE / near
    else:
        scale = views[one, 13]
        q = max(ONE - (near - views[one, 14]) / views[one, 19], TINY)
    return views[one, 15] + scale * x, views[one, 16] - scale * y, q


@inlined
def between(a, b, value, slope):
    """The part of a <= t <= b where value + slope · t >= 0; one that ends where it begins, or before, if there is none."""
    root = -value / slope  # where the slope is 0 this is not used
    low = max(a, root) if slope > ZERO else a
    high = min(b, root) if slope < ZERO else b
    return low, low if (slope == ZERO) & (value < ZERO) else high


@inner
def cross(xa, ya, qa, xb, yb, qb, a, b, i, last, keys, lines, low, high, opacity, at, cuts, clear):
    """Darken the parts of a line between its places a and b, points (xa, ya) and (xb, yb) of one cell, by the bands in
    front of it there: those of the keys from i to before last."""
    n = last - i
    behind = nearness(min(qa, qb))
    begin = a * np.float32(PARTS)
    size = b * np.float32(PARTS) - begin
    for k in range(0, n, BATCH):
        if keys[i + k] >= behind:
            return
        count = min(n - k, BATCH)
        cut(lines, ROWS * i + k, n, count, xa, ya, qa, xb, yb, qb, cuts)
        covered = False
        for m in range(count):
            if cuts[m] < cuts[BATCH + m]:
                v = keys[i + k + m] & LOW
                if v < low or v > high:
                    since = begin + cuts[m] * size
                    until = begin + cuts[BATCH + m] * size
                    for p in range(np.int64(since), min(np.int64(math.ceil(until)), PARTS)):
                        share = min(until, np.float32(p + 1)) - max(since, np.float32(p))
                        clear[at + p] *= ONE - opacity * max(share, ZERO)
                    covered = True
        if covered:
            lit = False
            for p in range(np.int64(begin), min(np.int64(math.ceil(begin + size)), PARTS)):
                lit |= clear[at + p] > DARK
            if not lit:
                return


@inner
def cut(lines, at, n, count, xa, ya, qa, xb, yb, qb, cuts):
    """From where to where each of some bands covers a line, whose ends are 0 and 1: the ends' rows in `cuts`."""
    for k in range(count):
        here = np.uint64(at + k)
        x = lines[here + np.uint64(ASIDE_X * n)]
        y = lines[here + np.uint64(ASIDE_Y * n)]
        c = lines[here + np.uint64(ASIDE * n)]
        sa = c + x * xa + y * ya
        sb = c + x * xb + y * yb
        x = lines[here + np.uint64(ALONG_X * n)]
        y = lines[here + np.uint64(ALONG_Y * n)]
        c = lines[here + np.uint64(ALONG * n)]
        ua = c + x * xa + y * ya
        ub = c + x * xb + y * yb
        q = lines[here + np.uint64(DEPTH * n)]
        grows = lines[here + np.uint64(GROWS * n)]
        low, high = between(ZERO, ONE, ONE - sa, sa - sb)
        low, high = between(low, high, ONE + sa, sb - sa)
        low, high = between(low, high, ua, ub - ua)
        low, high = between(low, high, ONE - ua, ua - ub)
        da = q + ua * grows - qa
        low, high = between(low, high, da, q + ub * grows - qb - da)
        cuts[k] = low
        cuts[BATCH + k] = high
