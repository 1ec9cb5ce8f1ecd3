"""Exact shadows of strands on strands: what of a strand's length other strands leave in the light.

Seen from the light a piece of a strand is a flat band, and a strand that is lit is a line. A band that crosses the line
in front of it darkens a part of its length, of which three pairs of linear inequalities tell the ends: within the
band's width, between the band's ends, nearer to the light than the line. A piece of the line has a bit for each of
many places along it, so many that a band as wide as the line is covers two, and what is dark is set.

`darkening` follows a line through the bands.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, inlined, parallel, prange
from ...common.kernels.bits import popcount
from ...common.kernels.view_columns import EYE_X, EYE_Y, EYE_Z, FORWARD_X, FORWARD_Y, FORWARD_Z, PERSPECTIVE
from ...coverage.kernels.column_light import LINES
from ...geometry.kernels.silhouette import STEEPEST
from .interval_bits import ALL, NONE, add_up
from .occluder_intervals import BATCH, piece

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
TINY = np.float32(1e-12)
RESOLVED, NARROW = np.float32(1.5), np.float32(0.5)
"""Samples. Strands as wide as that have shadows along every line across them, or along every second; others along every
fourth."""
MOST = np.int64(32)
"""Pieces to each side of a vertex that its light is averaged over, at most."""
STRANDS = 32
"""Strands a task."""
UNSEEN = np.float32(-1.0)


@parallel
def visibility(
    first, world, marks, screen, stride, most, views, sizes, cells, begin, keys, lines, words, veil, bias, apart, eye,
    width, taper, scale, slots, shown, shades, out,
):  # fmt: skip
    """Share of a light that strands leave at marked vertices: the mean over the strand's length about each.

    first, world, stride: polylines and their lit vertices; marks (V,) uint8: lit vertices where it is wanted; screen
    (V, 3): where a camera sees the vertices, in samples; most: pieces of the longest polyline. Of each of the light's
    views, views (M, 26) and sizes (M,), cells (M,) tells where its cells begin in begin (C,), which tells where their
    keys begin; keys, lines: as `grid.order` leaves them. Several views are the six sides of a cube. words: of bits for
    a piece; veil: opacity of strands, in 1 / `bits.VEILS`; bias: metres in front of which nothing is shaded; apart:
    metres, as the light sees them, within which a strand does not shade itself; out (V,).

    Where slots is not None: eye (26,) the camera; width metres at the root, of which `taper` is lost to the tip; scale
    (S,) or None; slots (V,) int32: number of each wide vertex, or −1; shown (n, LINES) uint64: what is wanted of the
    piece after each, a bit for each of 64 places along each of the lines across it that the camera sees, or (0, 0):
    all; shades (n, LINES) uint64: what of that is dark, and what is not wanted.

    The mean is weighted by a hat that reaches to the next lit vertices or over a sample of the picture, whichever is
    farther.
    """
    count = first.shape[0] - 1
    for task in prange((count + STRANDS - 1) // STRANDS):
        sums = np.empty(2 * (most + 1), np.float32)
        wanted = np.empty(most + 1, np.uint8)
        cuts = np.empty(2 * BATCH, np.float32)
        dark = np.empty(words, np.uint64)
        single = np.empty(1, np.uint64)
        pair = np.empty((2, 3), np.float32)
        for s in range(task * STRANDS, min((task + 1) * STRANDS, count)):
            a = first[s]
            n = first[s + 1] - a - 1
            if not want(a, n, marks, screen, stride, wanted):
                continue
            for p in range(n):
                if wanted[p] == 0:
                    continue
                low, high = beside(world, a, n, p, views, apart)
                if slots is not None:  # noqa: SIM102  a branch of its own is left out where there are none
                    if slots[a + p] >= 0:
                        half = HALF * width * (ONE if scale is None else scale[s])
                        lit = across(
                            world, a, n, p, slots[a + p], half, taper, screen[a + p, 2], eye, shown, views, sizes,
                            cells, begin, keys, lines, low, high, veil, bias, cuts, single, pair, shades,
                        )  # fmt: skip
                        sums[2 * p] = lit
                        sums[2 * p + 1] = HALF * lit
                        continue
                dark[:] = NONE
                for one in range(views.shape[0]):
                    piece(
                        world, a + p, a + p, views, one, sizes[one], cells[one], begin, keys, lines, low, high, veil,
                        bias, cuts, dark,
                    )  # fmt: skip
                add_up(dark, sums, p)
            for v in range(0, n + 1, stride):
                if marks[a + v] != 0:
                    out[a + v] = mean(sums, v, n, reach(screen, a, v, n, stride))


@device
def across(
    world, a, n, p, slot, half, taper, q, eye, shown, views, sizes, cells, begin, keys, lines, low, high, veil, bias,
    cuts, single, pair, shades,
):  # fmt: skip
    """Into shades: what is dark of the lines across piece p of a strand of n pieces, which begins with vertex a and is
    `half` a width wide at its root; q: the depth number there. Returns the share that is lit of what is shown, which
    alone is of account, or `UNSEEN`."""
    thin = half * taper / np.float32(n)
    together = shared(half, q, eye)
    left = np.int64(0)
    places = np.int64(0)
    for j in range(0, LINES, together):
        # of narrow ones, which may count in part, the mean over all of them is of account too
        need = ALL if shown.shape[0] == 0 or together > 2 else together_shown(shown, slot, j, together)
        single[0] = ~need
        if need != NONE:
            h = np.float32(2 * j + together) / np.float32(LINES) - ONE
            for end in range(2):
                surface(world, a, n, p + end, half - thin * np.float32(p + end), h, eye, pair, end)
            for one in range(views.shape[0]):
                piece(
                    pair, np.int64(0), a + p, views, one, sizes[one], cells[one], begin, keys, lines, low, high, veil,
                    bias, cuts, single,
                )  # fmt: skip
            left += np.int64(popcount(~single[0]))
            places += np.int64(popcount(need))
        shades[slot, j : j + together] = single[0]
    return np.float32(left) / np.float32(places) if places > 0 else UNSEEN


@device
def shared(half, q, eye):
    """How many lines across a strand have the shadow of one: the fewer samples of the camera `eye` (26,) show it, the
    more. half: of its width, metres; q: its depth number there."""
    wide = TWO * half * eye[13] * (q if eye[12] > ZERO else ONE)
    if wide >= RESOLVED:
        return np.int64(1)
    return np.int64(2) if wide >= NARROW else np.int64(4)


@device
def together_shown(shown, slot, line, count):
    """What is wanted of so many lines that have the shadow of one."""
    need = NONE
    for j in range(line, line + count):
        need |= shown[slot, j]
    return need


@device
def beside(world, a, n, p, views, apart):
    """From which to which vertex the pieces lie that do not shade piece p of the same strand, whose n pieces begin with
    vertex a: from p on as far as they are not `apart` metres aside of its middle, as the light of the `views` sees
    them. A strand that points to the light is all its length behind itself, but within its own width."""
    x = HALF * (world[a + p, 0] + world[a + p + 1, 0])
    y = HALF * (world[a + p, 1] + world[a + p + 1, 1])
    z = HALF * (world[a + p, 2] + world[a + p + 1, 2])
    lx = views[0, EYE_X] - x if views[0, PERSPECTIVE] > ZERO else views[0, FORWARD_X]
    ly = views[0, EYE_Y] - y if views[0, PERSPECTIVE] > ZERO else views[0, FORWARD_Y]
    lz = views[0, EYE_Z] - z if views[0, PERSPECTIVE] > ZERO else views[0, FORWARD_Z]
    per = ONE / max(lx * lx + ly * ly + lz * lz, TINY)
    low = p
    while low > 0 and aside(world, a + low, x, y, z, lx, ly, lz, per) < apart * apart:
        low -= 1
    high = p
    while high < n - 1 and aside(world, a + high + 1, x, y, z, lx, ly, lz, per) < apart * apart:
        high += 1
    return a + low, a + high


@inlined
def aside(world, v, x, y, z, lx, ly, lz, per):
    """Square of a vertex' distance from the line through a point (x, y, z) along (lx, ly, lz), per = 1 / |l|²."""
    dx = world[v, 0] - x
    dy = world[v, 1] - y
    dz = world[v, 2] - z
    along = (dx * lx + dy * ly + dz * lz) * per
    dx -= along * lx
    dy -= along * ly
    dz -= along * lz
    return dx * dx + dy * dy + dz * dz


@device
def surface(world, a, n, p, radius, h, eye, pair, row):
    """Into a row of `pair`: vertex p of a strand of n pieces that begins with vertex a, moved from the strand's middle
    to its surface, where the camera `eye` (26,) sees the offset h ∈ [−1, 1] as in `kernels.body`: aside, and then
    toward the eye, by r √(1 − h²) / cos ψ of a strand of the slant ψ, so that it is seen at the same place along the
    strand as its middle."""
    v = a + p
    low = a + max(p - 1, 0)
    high = a + min(p + 1, n)
    tx = world[high, 0] - world[low, 0]
    ty = world[high, 1] - world[low, 1]
    tz = world[high, 2] - world[low, 2]
    straight = eye[12] - ONE
    ex = eye[12] * (eye[20] - world[v, 0]) + straight * eye[8]
    ey = eye[12] * (eye[21] - world[v, 1]) + straight * eye[9]
    ez = eye[12] * (eye[22] - world[v, 2]) + straight * eye[10]
    bx = ty * ez - tz * ey
    by = tz * ex - tx * ez
    bz = tx * ey - ty * ex
    size = math.sqrt(max(bx * bx + by * by + bz * bz, TINY))
    across = radius * h / size
    out = radius * math.sqrt(ONE - h * h) * min(
        math.sqrt(tx * tx + ty * ty + tz * tz) / size, STEEPEST / math.sqrt(max(ex * ex + ey * ey + ez * ez, TINY))
    )
    pair[row, 0] = world[v, 0] + across * bx + out * ex
    pair[row, 1] = world[v, 1] + across * by + out * ey
    pair[row, 2] = world[v, 2] + across * bz + out * ez


@device
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


@device
def reach(screen, a, v, n, stride):
    """How many pieces to each side of vertex v its light is averaged over."""
    p = a + min(v, max(n - 1, 0))
    if n == 0 or screen[p, 2] <= ZERO or screen[p + 1, 2] <= ZERO:
        return stride
    dx = screen[p + 1, 0] - screen[p, 0]
    dy = screen[p + 1, 1] - screen[p, 1]
    size = math.sqrt(dx * dx + dy * dy)
    return max(stride, np.int64(math.ceil(min(ONE / max(size, TINY), np.float32(MOST)))))


@device
def mean(sums, v, n, far):
    """What of the light is left about vertex v of n pieces, weighted by a hat that reaches over `far` pieces."""
    total = ZERO
    weights = ZERO
    per = ONE / np.float32(far)
    for p in range(max(v - far, 0), v):
        if sums[2 * p] < ZERO:
            continue
        first = ONE - np.float32(v - p) * per
        total += first * sums[2 * p] + per * sums[2 * p + 1]
        weights += first + HALF * per
    for p in range(v, min(v + far, n)):
        if sums[2 * p] < ZERO:
            continue
        first = ONE - np.float32(p - v) * per
        total += first * sums[2 * p] - per * sums[2 * p + 1]
        weights += first - HALF * per
    return total / weights if weights > ZERO else ONE
