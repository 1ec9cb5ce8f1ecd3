"""Exact shadows of strands on strands: visibility of a light along each strand.

In the light's view the occluding segments are flat bands, and the shaded strand is a line. A band in front of the line
occludes an interval of it, given by three pairs of linear inequalities: within the band's width, between the band's
ends, nearer to the light than the line. Each segment of the line has a bit mask of positions along it, so fine that a
band as wide as the strand covers two of them; occluded positions are set.

`occluder_intervals` follows a line through the bands, and `self_shade` excludes the strand's own segments near the
shaded point.
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
from .interval_bits import ALL, MEAN, MOMENT, NONE, add_up
from .occluder_intervals import BATCH, OwnPieces, darken_line
from .self_shade import own_pieces

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
TINY = np.float32(1e-12)
RESOLVED, NARROW = np.float32(1.5), np.float32(0.5)
"""Widths in samples from which shadows are computed along each of the LINES across a strand, or along every second one;
narrower strands have them along every fourth."""
MOST = np.int64(32)
"""Greatest number of segments to each side of a vertex over which its visibility is averaged."""
STRANDS = 32
"""Strands a task."""
UNSEEN = np.float32(-1.0)
"""Marks a segment of which nothing is visible to the camera."""
NARROWER = np.float32(-2.0)
"""Marks a segment that is too narrow for lines across it."""


class ShadedLines(NamedTuple):
    """Polylines, and the vertices whose visibility is computed."""

    first: NDArray[np.int64]
    """(S + 1,) first vertex of each strand."""
    world: NDArray[np.float32]
    """(V, 3) metres."""
    along: NDArray[np.float32]
    """(V,) of which each vertex's width is smaller by the share `WideStrands.taper`; (0,): evenly from 0 to 1."""
    scale: NDArray[np.float32] | None
    """(S,) factor of each strand's width; None stands for 1."""
    marks: NDArray[np.uint8]
    """(V,) non-zero at the vertices to compute; only every `stride`-th vertex of a strand may be marked."""
    screen: NDArray[np.float32]
    """(V, 3) position of the vertices in the camera's view, samples, and depth number."""
    stride: int
    longest: int
    """Vertices of the longest strand."""
    words: int
    """64-bit words of positions along a segment."""
    apart: np.float32
    """Lateral distance in the light's view, metres, within which a strand of `scale` 1 does not shade itself."""


class WideStrands(NamedTuple):
    """Shadows across wide strands, at the vertices that have a slot."""

    eye: NDArray[np.float32] | None
    """(`view_columns.SIZE`,) the camera."""
    width: np.float32
    """Metres at the root; the width at the tip is smaller by the share `taper`."""
    taper: np.float32
    slots: NDArray[np.int32] | None
    """(V,) number of each wide vertex, or −1; None without wide vertices."""
    shown: NDArray[np.uint64]
    """(n, LINES) positions to compute on the segment after each wide vertex: a word for each line across the side that
    the camera sees, a bit for each of 64 positions along it; without rows all are computed."""
    shades: NDArray[np.uint64] | None
    """(n, LINES) out: bits of the occluded positions, and of those that were not computed."""
    together: int
    """Least number of neighbouring lines across a strand that share one computed shadow."""


class Work(NamedTuple):
    """Scratch arrays of one task."""

    sums: NDArray[np.float32]
    """(pieces, 2) visibility of each segment, as written by `interval_bits.add_up`."""
    wanted: NDArray[np.uint8]
    """(pieces,) non-zero for the segments to compute."""
    parts: NDArray[np.float32]
    """`parts` of `OwnPieces`."""
    cuts: NDArray[np.float32]
    """Output of `occluder_intervals.cut`."""
    dark: NDArray[np.uint64]
    """(words,)"""
    single: NDArray[np.uint64]
    """(1,)"""
    pair: NDArray[np.float32]
    """(2, 3) the ends of a line across a strand, metres."""


@parallel
def visibility(lit, lists, wide, out):
    """Write the visibility of a light, 0 to 1, at the marked vertices to out (V,), and the shades of `wide`.

    lit: `ShadedLines`; lists: the light's `OccluderLists`; wide: `WideStrands`. The visibility of a vertex is the mean
    over the strand's length around it, weighted by a hat function that reaches to the next shaded vertex or over one
    sample of the picture, whichever is farther.
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
            if not mark_wanted(a, n, lit.marks, lit.screen, lit.stride, work.wanted):
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
    """Return the factor of strand s's width."""
    return ONE if scale is None else scale[s]


@device
def light_piece(lit, lists, wide, work, a, n, p, size):
    """Write the visibility of segment p to row p of the sums. The strand has n segments and the first vertex a; size:
    factor of its width."""
    low, high = own_pieces(lit.world, a, n, p, lists.views, lit.apart * size, work.parts)
    own = OwnPieces(low, high, a, work.parts)
    across = light_across(lit, lists, wide, work, own, n, p, size, wide.slots)
    if across > NARROWER:
        work.sums[p, MEAN] = across
        work.sums[p, MOMENT] = HALF * across
        return
    work.dark[:] = NONE
    for one in range(lists.views.shape[0]):
        darken_line(lit.world, a + p, a + p, one, lists, own, work.cuts, work.dark)
    add_up(work.dark, work.sums, p)


@device
def light_across(lit, lists, wide, work, own, n, p, size, slots):
    """Write the shadows along the lines across segment p to the shades. Return the visibility of the positions that are
    shown, `UNSEEN` if there are none, or `NARROWER` if the segment has no lines across it."""
    if slots is None:  # an argument, not a field: Numba then compiles nothing of the rest where it is None
        return NARROWER
    a = own.root
    slot = slots[a + p]
    if slot < 0:
        return NARROWER
    half = HALF * wide.width * size
    together = max(shared(half, lit.screen[a + p, 2], wide.eye), np.int64(wide.together))
    left = np.int64(0)
    places = np.int64(0)
    for j in range(0, LINES, together):
        # narrow strands, whose lines may count in part, also need the mean over all lines
        need = ALL if wide.shown.shape[0] == 0 or together > 2 else together_shown(wide.shown, slot, j, together)
        work.single[0] = ~need
        if need != NONE:
            h = np.float32(2 * j + together) / np.float32(LINES) - ONE
            for end in range(2):
                v = p + end
                place = np.float32(v) / np.float32(n) if lit.along.shape[0] == 0 else lit.along[a + v]
                surface(lit.world, a, n, v, half * (ONE - wide.taper * place), h, wide.eye, work.pair, end)
            for one in range(lists.views.shape[0]):
                darken_line(work.pair, np.int64(0), a + p, one, lists, own, work.cuts, work.single)
            left += np.int64(popcount(~work.single[0]))
            places += np.int64(popcount(need))
        wide.shades[slot, j : j + together] = work.single[0]
    return np.float32(left) / np.float32(places) if places > 0 else UNSEEN


@device
def shared(half, q, eye):
    """Return how many neighbouring lines across a strand share one computed shadow: 1, 2 or 4, more for a strand that
    is fewer samples wide. half: half its width, metres; q: its depth number; eye: the camera."""
    wide = TWO * half * eye[FOCAL] * (q if eye[PERSPECTIVE] > ZERO else ONE)
    if wide >= RESOLVED:
        return np.int64(1)
    return np.int64(2) if wide >= NARROW else np.int64(4)


@device
def together_shown(shown, slot, line, count):
    """Return the union of the positions shown of `count` lines from number `line` on."""
    need = NONE
    for j in range(line, line + count):
        need |= shown[slot, j]
    return need


@device
def surface(world, a, n, p, radius, h, eye, pair, row):
    """Write vertex p of a strand, moved from its axis to its surface, to a row of `pair`.

    The surface point is where the camera `eye` sees the lateral offset h ∈ [−1, 1]: the vertex moves sideways by r h,
    and toward the eye by r √(1 − h²) / cos ψ, where ψ is the strand's slant, so that it appears at the same position
    along the strand. The strand has n segments and the first vertex a."""
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
    out = (
        radius
        * math.sqrt(ONE - h * h)
        * min(
            math.sqrt(tx * tx + ty * ty + tz * tz) / size, STEEPEST / math.sqrt(max(ex * ex + ey * ey + ez * ez, TINY))
        )
    )
    pair[row, 0] = world[v, 0] + across * bx + out * ex
    pair[row, 1] = world[v, 1] + across * by + out * ey
    pair[row, 2] = world[v, 2] + across * bz + out * ez


@device
def mark_wanted(a, n, marks, screen, stride, wanted):
    """Flag the segments that the marked vertices need; return whether there are any."""
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
    """Return how many segments to each side of vertex v its visibility is averaged over."""
    p = a + min(v, max(n - 1, 0))
    if n == 0 or screen[p, 2] <= ZERO or screen[p + 1, 2] <= ZERO:
        return stride
    dx = screen[p + 1, 0] - screen[p, 0]
    dy = screen[p + 1, 1] - screen[p, 1]
    size = math.sqrt(dx * dx + dy * dy)
    return max(stride, np.int64(math.ceil(min(ONE / max(size, TINY), np.float32(MOST)))))


@device
def mean(sums, v, n, far):
    """Return the mean visibility around vertex v of n segments, weighted by a hat function of `far` segments."""
    total = ZERO
    weights = ZERO
    per = ONE / np.float32(far)
    for p in range(max(v - far, 0), v):
        if sums[p, MEAN] < ZERO:
            continue
        first = ONE - np.float32(v - p) * per
        total += first * sums[p, MEAN] + per * sums[p, MOMENT]
        weights += first + HALF * per
    for p in range(v, min(v + far, n)):
        if sums[p, MEAN] < ZERO:
            continue
        first = ONE - np.float32(p - v) * per
        total += first * sums[p, MEAN] - per * sums[p, MOMENT]
        weights += first - HALF * per
    return total / weights if weights > ZERO else ONE
