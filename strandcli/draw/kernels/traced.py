"""Exact shadows of strands on strands: what of a strand's length other strands leave in the light.

Seen from the light a piece of a strand is a flat band, and a strand that is lit is a line. A band that crosses the line
in front of it darkens a part of its length, of which three pairs of linear inequalities tell the ends: within the
band's width, between the band's ends, nearer to the light than the line. No ray is cast and nothing is sampled: the
light along a piece of the line is a function of steps, kept as such.

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
STEPS = 96
"""Steps of the light along a piece at most; in those that there are then, parts are taken to darken the whole."""
SLIVER = np.float32(1e-5)
"""Part of a piece that is not worth a step."""
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
LEVEL, SPARE = STEPS, 2 * STEPS
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
        sums = np.empty(2 * (most + 1), np.float32)
        wanted = np.empty(most + 1, np.uint8)
        cuts = np.empty(2 * BATCH, np.float32)
        steps = np.empty(4 * STEPS, np.float32)
        for s in range(task * STRANDS, min((task + 1) * STRANDS, count)):
            a = first[s]
            n = first[s + 1] - a - 1
            if not want(a, n, marks, screen, stride, wanted):
                continue
            for p in range(n):
                if wanted[p] == 0:
                    continue
                low = max(p - apart, 0) + a
                high = min(p + apart, n - 1) + a
                steps[0] = ZERO
                steps[1] = ONE
                steps[LEVEL] = ONE
                parts = np.int64(1)
                for one in range(views.shape[0]):
                    parts = piece(
                        world, a + p, views, one, sizes[one], cells[one], begin, keys, lines, low, high, opacity, bias,
                        cuts, steps, parts,
                    )  # fmt: skip
                add_up(steps, parts, sums, p)
            for v in range(0, n + 1, stride):
                if marks[a + v] != 0:
                    out[a + v] = mean(sums, v, n, reach(screen, a, v, n, stride))


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
def add_up(steps, parts, sums, p):
    """Mean light of piece p, and what it comes to where it counts the more the nearer it is to the piece's end."""
    plain = ZERO
    toward = ZERO
    for i in range(parts):
        light = steps[LEVEL + i] * (steps[i + 1] - steps[i])
        plain += light
        toward += light * HALF * (steps[i + 1] + steps[i])
    sums[2 * p] = plain
    sums[2 * p + 1] = toward


@inner
def mean(sums, v, n, far):
    """What of the light is left about vertex v of n pieces, weighted by a hat that reaches over `far` pieces."""
    total = ZERO
    weights = ZERO
    per = ONE / np.float32(far)
    for p in range(max(v - far, 0), v):
        first = ONE - np.float32(v - p) * per
        total += first * sums[2 * p] + per * sums[2 * p + 1]
        weights += first + HALF * per
    for p in range(v, min(v + far, n)):
        first = ONE - np.float32(p - v) * per
        total += first * sums[2 * p] - per * sums[2 * p + 1]
        weights += first - HALF * per
    return total / weights if weights > ZERO else ONE


@inner
def piece(world, v, views, one, size, cells, begin, keys, lines, low, high, opacity, bias, cuts, steps, parts):
    """Darken the piece after vertex v by what one view shows in front of it, but not by the pieces after the vertices
    from `low` to `high`; how many parts of one light it is of then."""
    x0, y0, q0 = seen(world, v, views, one, bias)
    x1, y1, q1 = seen(world, v + 1, views, one, bias)
    if q0 <= ZERO or q1 <= ZERO:
        return parts
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
        return parts
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
                parts = cross(
                    x + a * dx, y + a * dy, q0 + a * dq, x + b * dx, y + b * dy, q0 + b * dq, a, b, begin[cell],
                    begin[cell + 1], keys, lines, low, high, opacity, cuts, steps, parts,
                )  # fmt: skip
    return parts


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
    """The part of a <= t <= b where value + slope · t >= 0; where there is none it ends before it
    begins, or there."""
    root = -value / slope  # where the slope is 0 this is not used
    low = max(a, root) if slope > ZERO else a
    high = min(b, root) if slope < ZERO else b
    return low, low if (slope == ZERO) & (value < ZERO) else high


@inner
def cross(xa, ya, qa, xb, yb, qb, a, b, i, last, keys, lines, low, high, opacity, cuts, steps, parts):
    """Darken a line between its places a and b, points (xa, ya) and (xb, yb) of one cell, by the bands in front of it
    there: those of the keys from i to before last. How many parts of one light it is of then."""
    n = last - i
    behind = nearness(min(qa, qb))
    for k in range(0, n, BATCH):
        if keys[i + k] >= behind:
            break
        count = min(n - k, BATCH)
        cut(lines, ROWS * i + k, n, count, xa, ya, qa, xb, yb, qb, cuts)
        covered = False
        for m in range(count):
            if cuts[m] < cuts[BATCH + m]:
                v = keys[i + k + m] & LOW
                if v < low or v > high:
                    parts = darken(steps, parts, a + cuts[m] * (b - a), a + cuts[BATCH + m] * (b - a), opacity)
                    covered = True
        if covered and not lit(steps, parts, a, b):
            break
    return parts


@inner
def lit(steps, parts, a, b):
    """Whether anything is left of the light between two places."""
    found = False
    for i in range(parts):
        found |= steps[LEVEL + i] > DARK and min(steps[i + 1], b) - max(steps[i], a) > SLIVER
    return found


@inner
def darken(steps, parts, since, until, opacity):
    """Darken what is between two places; how many parts there are then. The parts begin and end at the first `parts` +
    1 numbers of steps and have so much light as is told from number `LEVEL` on; beyond `SPARE` are places for as many.
    """
    n = np.int64(0)
    last = -ONE
    room = parts + 2 < STEPS
    for i in range(parts):
        begin = steps[i]
        end = steps[i + 1]
        level = steps[LEVEL + i]
        low = min(max(since, begin), end)
        high = min(max(until, begin), end)
        if not room:
            level *= ONE - opacity * (high - low) / (end - begin)
            high = low = begin
        for third in range(3):
            value = level * (ONE - opacity) if third == 1 else level
            left = begin if third == 0 else (low if third == 1 else high)
            right = low if third == 0 else (high if third == 1 else end)
            if right - left > SLIVER and value != last:
                steps[SPARE + n] = left
                steps[SPARE + LEVEL + n] = value
                last = value
                n += 1
    n = max(n, 1)
    steps[0] = ZERO
    steps[LEVEL] = steps[SPARE + LEVEL]
    for i in range(1, n):
        steps[i] = steps[SPARE + i]
        steps[LEVEL + i] = steps[SPARE + LEVEL + i]
    steps[n] = ONE
    return n


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
