"""Width profiles of strands near the camera: light that varies across their width.

The light of a thin strand is the average over its width, which is all that a pixel shows of it. For strands wider than
two pixels the average is resolved into columns of the offset h ∈ [−1, 1], each with its own part of the azimuthal
functions,

    N_p(θ, φ) = ½ ∫ A_p(θ, h) D(φ − Φ_p(h)) dh,

so that R is a narrow streak on the side of the light, TT the glow of a strand in front of it, TRT the coloured streaks
beside them. Light that is in no lobe, scattered from strand to strand, is distributed as a cosine. Only departures from
the average are stored, and their sum over the width is 0: the total light of a strand is the same as far away, and
between two and four pixels departures are faded in, so that nothing jumps as the camera comes near. The part of the
width that a pixel shows is averaged exactly, so that a strand three pixels wide does not flicker.

A wide vertex has a profile over the offset h ∈ [−1, 1] across the strand: the departure of its light from the average
over the width. h increases along b = t × e, where t is the tangent and e the direction to the eye; on the screen, with
y down, that is from a strand's direction (dx, dy) toward (−dy, dx).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import W
from ....jit import device, function, inlined, parallel, prange
from ....simd import broadcast, load, pointer, prefetch, store, triple_pointer
from ...common.kernels.approximations import clamp
from ...common.kernels.batch import BEFORE, EX, LX, RADIANCE, TX, vector_at
from ...common.kernels.keys import LOW
from ...common.kernels.numbers import HALF, ONE, THREE, TWO, ZERO
from .segments import TALL
from .tiles import PIXELS, TILE_WIDTH, tile_at

TINY = np.float32(1e-12)
COLUMNS = 16
"""Columns of the offset h across a strand."""
AHEAD = np.int64(16)
"""Fragments that slots are prefetched ahead of their use."""
FINEST = np.float32(1e-3)
"""Least half of the part of a profile that a sample shows, in columns; a smaller one is lost in rounding."""

_EDGES = np.linspace(-1.0, 1.0, COLUMNS + 1)
_AREA = 0.5 * (_EDGES * np.sqrt(1 - _EDGES**2) + np.arcsin(_EDGES))
OFFSET = np.float32(0.5) * (_EDGES[1:] + _EDGES[:-1]).astype(np.float32)
"""Mean of h over each column."""
HEIGHT = (np.diff(_AREA) * COLUMNS / 2 - math.pi / 4).astype(np.float32)
"""Mean of √(1 − h²) over each column, less the mean over all columns."""


class Profiles(NamedTuple):
    """Light across the width of strands, at the n vertices that are wide."""

    screen: NDArray[np.float32]
    """(V, 3) as in `ScreenLines`."""
    widths: NDArray[np.float32]
    """(V,) samples."""
    samples: np.float32
    """Samples along a side of a pixel."""
    start: np.float32
    full: np.float32
    """Widths, pixels, from which departures from the average begin to count, and count fully."""
    slots: NDArray[np.int32]
    """(V,) number of the vertex's profile, or −1."""
    profile: NDArray[np.float32]
    """(n, COLUMNS + 1, 3)"""


class VisiblePart(NamedTuple):
    """The part of a strand that a sample shows."""

    x: int
    y: int
    """The sample."""
    vertex: int
    """Lit vertex before the visible position."""
    along: np.float32
    """Visible position from that lit vertex to the next, 0 to 1."""
    stride: int
    """Vertices from a lit one to the next."""
    weight: np.float32
    """Share of the sample's light."""


@device
def clear(profile, slot):
    """Set a profile to 0; slot: −1 for none."""
    for i in range(COLUMNS + 1 if slot >= 0 else 0):
        for c in range(3):
            profile[slot, i, c] = ZERO


@device
def add_cosine_lobe(work, n, which, slots, profile):
    """Distribute the light that `RADIANCE` has more than `BEFORE` across wide strands as a cosine lobe around the side
    that faces the light: factor 1 + cos (γ − φ) − mean, where h = sin γ, which is never negative.

    which (W,): vertices of the batch; slots, profile: of `Profiles`."""
    for k in range(n):
        slot = slots[which[k]]
        if slot >= 0:
            cosine, sine = azimuth(work, k)
            for c in range(3):
                light = work[RADIANCE + c * W + k] - work[BEFORE + c * W + k]
                for i in range(COLUMNS):
                    profile[slot, i + 1, c] += light * (sine * OFFSET[i] + cosine * HEIGHT[i])


@device
def azimuth(work, k):
    """Return cosine and sine of the angle from the eye to the light around the tangent, positive toward b."""
    tx, ty, tz = vector_at(work, TX, k)
    ex, ey, ez = vector_at(work, EX, k)
    lx, ly, lz = vector_at(work, LX, k)
    sin_l = tx * lx + ty * ly + tz * lz
    sin_v = tx * ex + ty * ey + tz * ez
    size = ONE / math.sqrt(max((ONE - sin_l * sin_l) * (ONE - sin_v * sin_v), TINY))
    across = lx * (ty * ez - tz * ey) + ly * (tz * ex - tx * ez) + lz * (tx * ey - ty * ex)
    along = lx * ex + ly * ey + lz * ez - sin_l * sin_v
    return clamp(along * size, -ONE, ONE), clamp(across * size, -ONE, ONE)


@function
def integrate_columns(profile, slot):
    """Replace each column's light by the sum, up to the column's end, of departures from the average; the sum over all
    columns is 0."""
    for c in range(3):
        mean = ZERO
        for i in range(COLUMNS):
            mean += profile[slot, i + 1, c]
        mean /= np.float32(COLUMNS)
        total = ZERO
        for i in range(1, COLUMNS + 1):
            total += profile[slot, i, c] - mean
            profile[slot, i, c] = total
        profile[slot, COLUMNS, c] = ZERO


@inlined
def departure(rows, slot, low, high):
    """Return the mean of a vertex's profile between the offsets `low` and `high`, in columns, for all channels
    at once; 0 for slot −1, a vertex that is not wide. rows: `triple_pointer` to the profiles."""
    if slot < 0:
        return broadcast(rows, ZERO)
    return (integral_at(rows, slot, high) - integral_at(rows, slot, low)) / (high - low)


@device
def integral_at(rows, slot, place):
    """Return the sums from `integrate_columns` at an offset in [0, COLUMNS], interpolated by a cubic, so that their
    slope, the light, is continuous."""
    i = min(np.int64(place), COLUMNS - 1)
    t = place - np.float32(i)
    at = 3 * (np.int64(slot) * (COLUMNS + 1) + i)
    a, b = load(rows, at), load(rows, at + 3)
    rise = b - a
    before = after = rise
    if i > 0:
        before = HALF * (rise + a - load(rows, at - 3))
    if i + 2 <= COLUMNS:
        after = HALF * (rise + load(rows, at + 6) - b)
    return a + t * (before + t * ((THREE * rise - TWO * before - after) + t * (before + after - TWO * rise)))


@device
def add_departure(part, profiles, image):
    """Add the departure of a strand's light from the average that a sample already has; one of its ends has a profile.

    part: `VisiblePart`; profiles: `Profiles`; image (height, width, 3): changed.
    """
    x, y, v, t, stride, weight = part
    screen, widths, samples, start, full, slots, profile = profiles
    past = t * np.float32(stride)
    piece = min(np.int64(past), stride - 1)
    p = v + piece
    past -= np.float32(piece)
    dx = screen[p + 1, 0] - screen[p, 0]
    dy = screen[p + 1, 1] - screen[p, 1]
    size = math.sqrt(dx * dx + dy * dy)
    wide = widths[p] + past * (widths[p + 1] - widths[p])
    counts = clamp((wide / samples - start) / (full - start), ZERO, ONE)
    if counts <= ZERO or size < TINY:
        return
    off = ((np.float32(y) + HALF - screen[p, 1]) * dx - (np.float32(x) + HALF - screen[p, 0]) * dy) / size
    weight *= counts * counts * (THREE - TWO * counts)
    per, middle = np.float32(COLUMNS) / wide, HALF * np.float32(COLUMNS)
    half = max(HALF * per, FINEST)
    least, most = np.float32(0.02) * half, np.float32(COLUMNS)
    low = clamp(middle + off * per - half, ZERO, most - least)
    high = clamp(middle + off * per + half, low + least, most)
    rows, picture = triple_pointer(profile), triple_pointer(image)
    one, two = departure(rows, slots[v], low, high), departure(rows, slots[v + stride], low, high)
    here = 3 * (y * image.shape[1] + x)
    store(picture, here, max(load(picture, here) + weight * (one + t * (two - one)), ZERO))


@parallel
def add_to_zbuffer(keys, base, per, stride, profiles, image):
    """Add the departures of strands in a z-buffer to the picture; keys, base, per, stride, image: as in `film.colours`;
    profiles: `Profiles`."""
    height, width, _ = image.shape
    last = np.uint64(max(profiles.screen.shape[0] - 1, 0))
    for row in prange(height):
        y = np.int64(row)
        screen = profiles.screen
        for x in range(width):
            number = (keys[y * width + x] & LOW) - np.uint64(base)
            if number >= last:
                continue
            v = np.int64(number)
            dx = screen[v + 1, 0] - screen[v, 0]
            dy = screen[v + 1, 1] - screen[v, 1]
            t = (np.float32(x) + HALF - screen[v, 0]) * dx + (np.float32(y) + HALF - screen[v, 1]) * dy
            t = clamp(t / max(dx * dx + dy * dy, TINY), ZERO, ONE)
            if stride > 1:
                past = (v % per) % stride
                v -= past
                t = (np.float32(past) + t) / np.float32(stride)
            if profiles.slots[v] >= 0 or profiles.slots[v + stride] >= 0:
                add_departure(VisiblePart(x, y, v, t, stride, ONE), profiles, image)


@parallel
def add_to_fragments(fragments, profiles, image):
    """Add the departures of sorted fragments to the picture; fragments: `tiles.Fragments`; profiles: `Profiles`."""
    start = profiles.start * profiles.samples
    for one in prange(fragments.begin.shape[0]):
        number = np.int64(one)
        f = fragments.begin[number]
        # most tiles show no strand that is so wide; of thin segments it is not known how wide they are
        if f < 0 or (start >= TALL and fragments.widest[number] <= start):
            continue
        tile = tile_at(number, fragments)
        slots = profiles.slots
        vertex, weight, along = fragments.vertex, fragments.weight, fragments.along
        for p in range(PIXELS):
            end = f + np.int64(fragments.counts[number * PIXELS + p])
            while f < end:
                v = np.int64(vertex[f])
                prefetch(pointer(slots), np.int64(vertex[min(f + AHEAD, vertex.shape[0] - 1)]))
                # greater numbers are edges of solids; of a picture's strands, few are wide; what weighs little is left
                if v < slots.shape[0] and along[f] >= ZERO and (slots[v] >= 0 or slots[v + fragments.stride] >= 0):
                    part = VisiblePart(
                        tile.left + p % TILE_WIDTH, tile.top + p // TILE_WIDTH, v, along[f], fragments.stride,
                        weight[f],
                    )  # fmt: skip
                    add_departure(part, profiles, image)
                f += 1
