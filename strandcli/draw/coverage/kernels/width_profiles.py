"""Light across the width of strands that are wider than a few pixels (see `strandcli.draw.coverage.width_profiles`).

A vertex that is wide has a profile over the offset h ∈ [−1, 1] across the strand: how far its light there departs from
the average over the width. In front of the eye h grows along b = t × e, t the tangent and e the way to the eye; on the
screen, with y down, that is from a strand's direction (dx, dy) toward (−dy, dx).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import W
from ....jit import device, function, parallel, prange
from ...common.kernels.approximations import clamp
from ...common.kernels.batch import (
    ADDED,
    BEFORE,
    EX,
    EY,
    EZ,
    LX,
    LY,
    LZ,
    RADIANCE,
    TX,
    TY,
    TZ,
)
from ...common.kernels.keys import LOW
from .column_light import COLUMNS, Crossing, column_light
from .masks import WHOLE
from .tiles import PIXELS, TILE_WIDTH, tile_at

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
THREE = np.float32(3.0)
TINY = np.float32(1e-12)
FINEST = np.float32(1e-3)
"""Half the share of a profile that a sample sees at least, in columns: less is lost in rounding."""

_EDGES = np.linspace(-1.0, 1.0, COLUMNS + 1)
_AREA = 0.5 * (_EDGES * np.sqrt(1 - _EDGES**2) + np.arcsin(_EDGES))
OFFSET = np.float32(0.5) * (_EDGES[1:] + _EDGES[:-1]).astype(np.float32)
"""Mean of h over each column."""
HEIGHT = (np.diff(_AREA) * COLUMNS / 2 - math.pi / 4).astype(np.float32)
"""Mean of √(1 − h²) over each column, less that over all."""


class Profiles(NamedTuple):
    """The light across the width of some strands, at the n vertices that are wide."""

    screen: NDArray[np.float32]
    """(V, 3) as in `ScreenLines`."""
    widths: NDArray[np.float32]
    """(V,) samples."""
    samples: np.float32
    """Along each side of a pixel."""
    start: np.float32
    full: np.float32
    """Widths in pixels from which departures from the average count, and count fully."""
    slots: NDArray[np.int32]
    """(V,) number of the vertex' profile, or −1."""
    profile: NDArray[np.float32]
    """(1 + m, n, COLUMNS + 1, 3) of what has no exact shadows, and of each of the m lights that have."""
    shades: NDArray[np.uint64] | None
    """(m, n, LINES) what exact shadows darken of the piece after each of these vertices; None: m is 0."""


class Shown(NamedTuple):
    """What a sample shows of a strand."""

    x: int
    y: int
    """The sample."""
    vertex: int
    """The lit vertex before the place that is shown."""
    along: np.float32
    """That place on the way to the next lit vertex, 0 to 1."""
    stride: int
    """Vertices from a lit one to the next."""
    weight: np.float32
    """Share of the sample's light."""
    points: np.uint64
    """Points of the sample that show it (see `masks`)."""


@device
def begin(profile, slot):
    """An empty profile."""
    for row in range(profile.shape[0]):
        for i in range(COLUMNS + 1):
            for c in range(3):
                profile[row, slot, i, c] = ZERO


@device
def remember(work):
    """Note the radiance of a batch before light of a kind is added."""
    for k in range(3 * W):
        work[BEFORE + k] = work[RADIANCE + k]


@device
def round_off(work, n, which, slots, profile, row):
    """Light that has been added since `remember` as a cosine lobe about the side that faces it: times
    1 + cos (γ − φ) − mean, h = sin γ, which is nowhere negative."""
    for k in range(n):
        slot = slots[which[k]]
        if slot >= 0:
            cosine, sine = azimuth(work, k)
            for c in range(3):
                light = work[RADIANCE + c * W + k] - work[BEFORE + c * W + k]
                for i in range(COLUMNS):
                    profile[row, slot, i + 1, c] += light * (sine * OFFSET[i] + cosine * HEIGHT[i])


@device
def azimuth(work, k):
    """Cosine and sine of the angle from the eye to the light about the tangent, positive toward b."""
    tx, ty, tz = work[TX + k], work[TY + k], work[TZ + k]
    ex, ey, ez = work[EX + k], work[EY + k], work[EZ + k]
    lx, ly, lz = work[LX + k], work[LY + k], work[LZ + k]
    sin_l = tx * lx + ty * ly + tz * lz
    sin_v = tx * ex + ty * ey + tz * ez
    size = ONE / math.sqrt(max((ONE - sin_l * sin_l) * (ONE - sin_v * sin_v), TINY))
    across = lx * (ty * ez - tz * ey) + ly * (tz * ex - tx * ez) + lz * (tx * ey - ty * ex)
    along = lx * ex + ly * ey + lz * ez - sin_l * sin_v
    return clamp(along * size, -ONE, ONE), clamp(across * size, -ONE, ONE)


@device
def darken(work, n, which, slots, profile, row, clear):
    """Leave of the light that has been added since `remember` what exact shadows do: of its average over the width the
    share `clear` (lights, V). Profiles of wide strands have all of it in their own `row`, for `column_light`, and in
    the first one what takes the place of the average."""
    for c in range(3):
        for k in range(n):
            before = work[BEFORE + c * W + k]
            work[ADDED + k] = work[RADIANCE + c * W + k] - before
            work[RADIANCE + c * W + k] = before + clear[row - 1, which[k]] * work[ADDED + k]
        for k in range(n):
            slot = slots[which[k]]
            if slot >= 0:
                light = work[ADDED + k]
                left = clear[row - 1, which[k]] * light
                for i in range(COLUMNS):
                    profile[row, slot, i + 1, c] += light
                    profile[0, slot, i + 1, c] -= left


@function
def add_up(profile, slot):
    """From each column's light to that of all columns up to its end: departures from an average, which come to nothing
    at the last. Where there are rows of lights with exact shadows columns stay as they are."""
    if profile.shape[0] > 1:
        return
    for c in range(3):
        mean = ZERO
        for i in range(COLUMNS):
            mean += profile[0, slot, i + 1, c]
        mean /= np.float32(COLUMNS)
        total = ZERO
        for i in range(1, COLUMNS + 1):
            total += profile[0, slot, i, c] - mean
            profile[0, slot, i, c] = total
        profile[0, slot, COLUMNS, c] = ZERO


@function
def departure(profile, slots, v, c, low, high):
    """Mean of the first row of a vertex' profile between the offsets `low` and `high`, in columns; 0 where it is not
    wide."""
    slot = slots[v]
    if slot < 0:
        return ZERO
    return (gathered(profile, slot, c, high) - gathered(profile, slot, c, low)) / (high - low)


@device
def gathered(profile, slot, c, place):
    """What `add_up` made at a place in [0, COLUMNS]: a cubic whose slope, the light, has no steps."""
    i = min(np.int64(place), COLUMNS - 1)
    t = place - np.float32(i)
    a = profile[0, slot, i, c]
    b = profile[0, slot, i + 1, c]
    rise = b - a
    before = HALF * (rise + a - profile[0, slot, i - 1, c]) if i > 0 else rise
    after = HALF * (rise + profile[0, slot, i + 2, c] - b) if i + 2 <= COLUMNS else rise
    return a + t * (before + t * ((THREE * rise - TWO * before - after) + t * (before + after - TWO * rise)))


@device
def add_departure(shown, table, profiles, shades, shares, image):
    """Add what a strand's light in a sample departs from the average that is there.

    shown: `Shown`; table: of `strandcli.draw.coverage.masks.sides`, or None: all points show it; shades: of `profiles`,
    which are `Profiles`; shares (COLUMNS,) float32 to work with.
    """
    x, y, v, t, stride, weight, _ = shown
    screen, widths, samples, start, full, slots, profile, _ = profiles
    if slots[v] < 0 and slots[v + stride] < 0:
        return
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
    after = slots[v + stride]
    if shades is None:
        per = np.float32(COLUMNS) / wide
        middle = HALF * np.float32(COLUMNS)
        half = max(HALF * per, FINEST)
        least = np.float32(0.02) * half
        low = clamp(middle + off * per - half, ZERO, np.float32(COLUMNS) - least)
        high = clamp(middle + off * per + half, low + least, np.float32(COLUMNS))
        for c in range(3):
            one = departure(profile, slots, v, c, low, high)
            two = departure(profile, slots, v + stride, c, low, high)
            image[y, x, c] = max(image[y, x, c] + weight * (one + t * (two - one)), ZERO)
    elif slots[v] >= 0 and after >= 0:
        crossing = Crossing(dx / size, dy / size, off, HALF * wide)
        r, g, b = column_light(profile, shades, slots[v], after, t, HALF / size, shown.points, table, crossing, shares)
        image[y, x, 0] = max(image[y, x, 0] + weight * r, ZERO)
        image[y, x, 1] = max(image[y, x, 1] + weight * g, ZERO)
        image[y, x, 2] = max(image[y, x, 2] + weight * b, ZERO)


@parallel
def add_to_zbuffer(keys, base, per, stride, profiles, image):
    """Departures in the picture of a z-buffer; keys, base, per, stride, image as in `film.colours`; profiles:
    `Profiles`."""
    height, width, _ = image.shape
    last = np.uint64(max(profiles.screen.shape[0] - 1, 0))
    for row in prange(height):
        y = np.int64(row)
        screen, shades = profiles.screen, profiles.shades
        shares = np.empty(COLUMNS, np.float32)
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
            shown = Shown(x, y, v, t, stride, ONE, WHOLE)
            add_departure(shown, None, profiles, shades, shares, image)


@parallel
def add_to_fragments(fragments, table, profiles, image):
    """Departures in the picture of sorted fragments, `tiles.Fragments`; table: of `masks.sides`; profiles:
    `Profiles`."""
    for one in prange(fragments.begin.shape[0]):
        number = np.int64(one)
        f = fragments.begin[number]
        if f < 0:
            continue
        tile = tile_at(number, fragments)
        slots, shades = profiles.slots, profiles.shades
        place, weight, along, seen = fragments.place, fragments.weight, fragments.along, fragments.seen
        shares = np.empty(COLUMNS, np.float32)
        for p in range(PIXELS):
            end = f + np.int64(fragments.kept[number * PIXELS + p])
            while f < end:
                v = np.int64(place[f])
                if v < slots.shape[0]:  # beyond are the edges of solids
                    shown = Shown(
                        tile.left + p % TILE_WIDTH, tile.top + p // TILE_WIDTH, v, along[f], fragments.stride,
                        weight[f], WHOLE if seen.shape[0] == 0 else seen[f],
                    )  # fmt: skip
                    add_departure(shown, table, profiles, shades, shares, image)
                f += 1
