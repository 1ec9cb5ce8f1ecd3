"""Exact shadows of strands on strands: what of a strand's length other strands leave in the light.

Seen from the light a piece of a strand is a flat band, and a strand that is lit is a line. A band that crosses the line
in front of it darkens a part of its length, of which three pairs of linear inequalities tell the ends: within the
band's width, between the band's ends, nearer to the light than the line. A piece of the line has a bit for each of
many places along it, so many that a band as wide as the line is covers two, and what is dark is set.

`occluder_intervals` follows a line through the bands, and `self_shade` tells which of a strand's own bands do not
count.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, parallel, prange
from ...common.kernels.bits import popcount
from ...common.kernels.view_columns import EYE_X, EYE_Y, EYE_Z, FOCAL, FORWARD_X, FORWARD_Y, FORWARD_Z, PERSPECTIVE
from ...coverage.kernels.column_light import LINES
from ...geometry.kernels.silhouette import STEEPEST
from .interval_bits import ALL, NONE, add_up
from .occluder_intervals import BATCH, OwnPieces, darken_line
from .self_shade import own_pieces

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
"""Light of a piece of which nothing is shown."""
NARROWER = np.float32(-2.0)
"""Light of a piece that has no lines across it."""


class LitLines(NamedTuple):
    """Polylines and where on them light is wanted."""

    first: NDArray[np.int64]
    """(S + 1,) first vertex of each strand."""
    world: NDArray[np.float32]
    """(V, 3) metres."""
    scale: NDArray[np.float32] | None
    """(S,) factor of each strand's width, or None: 1."""
    marks: NDArray[np.uint8]
    """(V,) not zero at the vertices where light is wanted; of each strand every `stride`-th vertex may be marked."""
    screen: NDArray[np.float32]
    """(V, 3) where a camera sees the vertices: samples, and depth number."""
    stride: int
    longest: int
    """Vertices of the longest strand."""
    words: int
    """Of 64 places along a piece."""
    apart: np.float32
    """Metres aside, as the light sees them, within which a strand as wide as `scale` 1 does not shade itself."""


class WideStrands(NamedTuple):
    """Where and how shadows are wanted across strands, at the vertices that have a slot."""

    eye: NDArray[np.float32] | None
    """(`view_columns.SIZE`,) the camera."""
    width: np.float32
    """Metres at the root, of which `taper` is lost to the tip."""
    taper: np.float32
    slots: NDArray[np.int32] | None
    """(V,) number of each wide vertex, or −1; None where there are none."""
    shown: NDArray[np.uint64]
    """(n, LINES) what is wanted of the piece after each wide vertex, a bit for each of 64 places along each of the
    lines across it that the camera sees; no rows: all."""
    shades: NDArray[np.uint64] | None
    """(n, LINES) out: what of that is dark, and what is not wanted."""


class Work(NamedTuple):
    """Arrays of one task."""

    sums: NDArray[np.float32]
    """(pieces, 2) of each piece of a strand, as `interval_bits.add_up` leaves them."""
    wanted: NDArray[np.uint8]
    """(pieces,) not zero where light is wanted."""
    parts: NDArray[np.float32]
    """Of `OwnPieces`."""
    cuts: NDArray[np.float32]
    """Of `occluder_intervals.cut`."""
    dark: NDArray[np.uint64]
    """(words,)"""
    single: NDArray[np.uint64]
    """(1,)"""
    pair: NDArray[np.float32]
    """(2, 3) the ends of a line across a strand, metres."""


@parallel
def visibility(lit, lists, wide, out):
    """Into out (V,): the share of a light that strands leave at the marked vertices of `LitLines`, the mean over the
    strand's length about each; lists: the light's `OccluderLists`; wide: `WideStrands`, whose shades are written.

    The mean is weighted by a hat that reaches to the next lit vertices or over a sample of the picture, whichever is
    farther.
    """
    count = lit.first.shape[0] - 1
    for task in prange((count + STRANDS - 1) // STRANDS):
        work = Work(
            np.empty((lit.longest + 1, 2), np.float32), np.empty(lit.longest + 1, np.uint8),
            np.empty((lit.longest + 1, 2), np.float32), np.empty(2 * BATCH, np.float32), np.empty(lit.words, np.uint64),
            np.empty(1, np.uint64), np.empty((2, 3), np.float32),
        )  # fmt: skip
        for s in range(task * STRANDS, min((task + 1) * STRANDS, count)):
            a = lit.first[s]
            n = lit.first[s + 1] - a - 1
            if not want(a, n, lit.marks, lit.screen, lit.stride, work.wanted):
                continue
            size = scale_of(lit.scale, s)
            for p in range(n):
                if work.wanted[p] != 0:
                    light_piece(lit, lists, wide, work, a, n, p, size)
            for v in range(0, n + 1, lit.stride):
                if lit.marks[a + v] != 0:
                    out[a + v] = mean(work.sums, v, n, reach(lit.screen, a, v, n, lit.stride))


@device
def scale_of(scale, s):
    """Factor of a strand's width."""
    return ONE if scale is None else scale[s]


@device
def light_piece(lit, lists, wide, work, a, n, p, size):
    """Into row p of the sums: the light of piece p of a strand of n pieces, which begins with vertex a and is `size`
    times as wide as usual."""
    low, high = own_pieces(lit.world, a, n, p, lists.views, lit.apart * size, work.parts)
    own = OwnPieces(low, high, a, work.parts)
    across = light_across(lit, lists, wide, work, own, n, p, size, wide.slots)
    if across > NARROWER:
        work.sums[p, 0] = across
        work.sums[p, 1] = HALF * across
        return
    work.dark[:] = NONE
    for one in range(lists.views.shape[0]):
        darken_line(lit.world, a + p, a + p, one, lists, own, work.cuts, work.dark)
    add_up(work.dark, work.sums, p)


@device
def light_across(lit, lists, wide, work, own, n, p, size, slots):
    """Into the shades: what is dark of the lines across a piece. Returns the share that is lit of what is shown, which
    alone is of account; `UNSEEN` where nothing is, and `NARROWER` where the piece has no lines across it."""
    if slots is None:  # asked of an argument, so that there is no code for what follows where there are none
        return NARROWER
    a = own.root
    slot = slots[a + p]
    if slot < 0:
        return NARROWER
    half = HALF * wide.width * size
    thin = half * wide.taper / np.float32(n)
    together = shared(half, lit.screen[a + p, 2], wide.eye)
    left = np.int64(0)
    places = np.int64(0)
    for j in range(0, LINES, together):
        # of narrow ones, which may count in part, the mean over all of them is of account too
        need = ALL if wide.shown.shape[0] == 0 or together > 2 else together_shown(wide.shown, slot, j, together)
        work.single[0] = ~need
        if need != NONE:
            h = np.float32(2 * j + together) / np.float32(LINES) - ONE
            for end in range(2):
                surface(lit.world, a, n, p + end, half - thin * np.float32(p + end), h, wide.eye, work.pair, end)
            for one in range(lists.views.shape[0]):
                darken_line(work.pair, np.int64(0), a + p, one, lists, own, work.cuts, work.single)
            left += np.int64(popcount(~work.single[0]))
            places += np.int64(popcount(need))
        wide.shades[slot, j : j + together] = work.single[0]
    return np.float32(left) / np.float32(places) if places > 0 else UNSEEN


@device
def shared(half, q, eye):
    """How many lines across a strand have the shadow of one: the fewer samples of the camera `eye` show it, the
    more. half: of its width, metres; q: its depth number there."""
    wide = TWO * half * eye[FOCAL] * (q if eye[PERSPECTIVE] > ZERO else ONE)
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
def surface(world, a, n, p, radius, h, eye, pair, row):
    """Into a row of `pair`: vertex p of a strand of n pieces that begins with vertex a, moved from the strand's middle
    to its surface, where the camera `eye` sees the offset h ∈ [−1, 1] as in `kernels.body`: aside, and then
    toward the eye, by r √(1 − h²) / cos ψ of a strand of the slant ψ, so that it is seen at the same place along the
    strand as its middle."""
    v = a + p
    low = a + max(p - 1, 0)
    high = a + min(p + 1, n)
    tx = world[high, 0] - world[low, 0]
    ty = world[high, 1] - world[low, 1]
    tz = world[high, 2] - world[low, 2]
    straight = eye[PERSPECTIVE] - ONE
    ex = eye[PERSPECTIVE] * (eye[EYE_X] - world[v, 0]) + straight * eye[FORWARD_X]
    ey = eye[PERSPECTIVE] * (eye[EYE_Y] - world[v, 1]) + straight * eye[FORWARD_Y]
    ez = eye[PERSPECTIVE] * (eye[EYE_Z] - world[v, 2]) + straight * eye[FORWARD_Z]
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
        if sums[p, 0] < ZERO:
            continue
        first = ONE - np.float32(v - p) * per
        total += first * sums[p, 0] + per * sums[p, 1]
        weights += first + HALF * per
    for p in range(v, min(v + far, n)):
        if sums[p, 0] < ZERO:
            continue
        first = ONE - np.float32(p - v) * per
        total += first * sums[p, 0] - per * sums[p, 1]
        weights += first - HALF * per
    return total / weights if weights > ZERO else ONE
