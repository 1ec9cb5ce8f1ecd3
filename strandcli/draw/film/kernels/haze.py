"""Haze over strands and solids (see `strandcli.draw.film.haze`).

What is to be changed is listed first, without branches; the exponential function of all that is listed takes vectors.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....jit import device, inlined, parallel, prange
from ....simd import lane_count, load, pointer, prefetch, store
from ...common.kernels.approximations import exp2_lanes
from ...common.kernels.keys import EMPTY, FIRST, LOW, SHIFT
from ...common.kernels.numbers import ONE, ZERO

NEAREST = np.float32(1e-12)
"""Least depth number of a perspective view, 1 / metres."""
ONE_ON, TWO_ON, THREE = np.uint64(1), np.uint64(2), np.uint64(3)
NO_MARK = np.uint64(0)
WORD = np.int64(8)
"""Marks that are read at once."""
LINE = np.int64(16)
"""Numbers of a cache line."""
AT_ONCE = 1 << 12
"""Vertices or pixels a task, a multiple of `WORD`."""
SPARE = 16
"""Places of a list past its end: the last vector may end in them."""


class Air(NamedTuple):
    """How light fades with depth."""

    rate: np.float32
    """By how much the binary logarithm of light grows a metre, less than 0."""
    perspective: np.float32
    """1 where depth numbers are 1 / depth, else 0."""
    near: np.float32
    """Depth of the number 1 of an orthographic view, metres."""
    reach: np.float32
    """Its depth of the number 0 minus that."""


@inlined
def arrives(air, numbers, count):
    """Replace depth numbers (count + `SPARE`,) by the shares of light that arrive from there."""
    rows = pointer(numbers)
    for k in range(0, count, lane_count(rows)):
        if air.perspective > ZERO:
            depth = ONE / max(NEAREST, load(rows, k))
        else:
            depth = max(ZERO, air.near + (ONE - load(rows, k)) * air.reach)
        store(rows, k, exp2_lanes(depth * air.rate))


@parallel
def veil_strands(air, backdrop, screen, marks, words, colours, slots, profile):
    """Blend the colours (V, 3) of vertices with marks (V,) with the backdrop (height, width, 3) behind them, and scale
    their width profiles alike.

    air: `Air`; screen (V, 3); words (V // `WORD`,) uint64: the marks, `WORD` of them in each; slots (V,) int32: number
    of each vertex's profile, or −1, (0,): none has one; profile (profiles, columns, 3).
    """
    count = np.int64(marks.shape[0])
    light = colours.reshape(-1)
    for one in prange((count + AT_ONCE - 1) // AT_ONCE):
        begin = np.int64(one) * AT_ONCE
        places, behind = np.empty(AT_ONCE, np.uint64), np.empty(AT_ONCE, np.uint64)
        shares = np.empty(AT_ONCE + SPARE, np.float32)
        n = list_marked(marks, words, begin, min(begin + AT_ONCE, count), screen, colours, places)
        find_behind(backdrop, screen, places, n, behind, shares)
        arrives(air, shares, n)
        blend(pointer(backdrop), behind, light, places, shares, n)
        for k in range(n if slots.shape[0] > 0 else 0):
            slot = slots[places[k] // THREE]
            if slot >= 0:
                for j in range(profile.shape[1]):
                    for c in range(3):
                        profile[slot, j, c] *= shares[k]


@device
def list_marked(marks, words, begin, end, screen, colours, places):
    """List where the numbers of the marked vertices from begin … end − 1 start; return how many they are. begin: a
    multiple of `WORD`; screen, colours: only prefetched."""
    n = np.uint64(0)
    rows, octets, points, radiance = pointer(marks), pointer(words), pointer(screen), pointer(colours)
    whole = end // WORD
    for word in range(begin // WORD, whole):
        if octets[word] != NO_MARK:
            for at in (3 * WORD * word, 3 * WORD * word + LINE):
                prefetch(points, at)
                prefetch(radiance, at)
            for v in range(np.uint64(word * WORD), np.uint64((word + 1) * WORD)):
                places[n] = THREE * v
                n += np.uint64(rows[v] != 0)
    for v in range(np.uint64(max(begin, whole * WORD)), np.uint64(end)):
        places[n] = THREE * v
        n += np.uint64(rows[v] != 0)
    return np.int64(n)


@device
def find_behind(backdrop, screen, places, n, behind, numbers):
    """Write where the backdrop behind each of n vertices starts, and the vertices' depth numbers."""
    width = np.int64(backdrop.shape[1])
    right, bottom = np.float32(width - 1), np.float32(backdrop.shape[0] - 1)
    points, picture = pointer(screen), pointer(backdrop)
    for k in range(np.uint64(n)):
        v = places[k]
        at = THREE * np.uint64(inside(points[v + ONE_ON], bottom) * width + inside(points[v], right))
        behind[k] = at
        numbers[k] = points[v + TWO_ON]
        prefetch(picture, at)


@inlined
def inside(x, last):
    """Return the pixel at a position, the nearest of 0 … last; the first for one that is no number."""
    return np.int64(min(x if x > ZERO else ZERO, last))


@inlined
def blend(background, behind, light, places, shares, n):
    """Blend n colours of light, which start at places, with those of the background that start at ``behind``."""
    old = pointer(light)
    for k in range(np.uint64(n)):
        v, at = places[k], behind[k]
        for c in range(THREE):
            far = background[at + c]
            light[v + c] = far + shares[k] * (old[v + c] - far)


@parallel
def veil_solids(air, behind, keys, hidden, light):
    """Blend the solids of a picture, light (P, 3), with what is behind them (P, 3); keys (P,): z-buffer; hidden (P,):
    not 0 at pixels that are left as they are, (0,): none are."""
    count = np.int64(keys.shape[0])
    flat = light.reshape(-1)
    for one in prange((count + AT_ONCE - 1) // AT_ONCE):
        begin = np.int64(one) * AT_ONCE
        places, shares = np.empty(AT_ONCE, np.uint64), np.empty(AT_ONCE + SPARE, np.float32)
        n = list_solids(keys, hidden, begin, min(begin + AT_ONCE, count), places, shares)
        arrives(air, shares, n)
        blend(pointer(behind), places, flat, places, shares, n)


@device
def list_solids(keys, hidden, begin, end, places, numbers):
    """List where the numbers of pixels from begin … end − 1 start that show a solid and are not hidden, and their
    depth numbers; return how many they are."""
    n = np.uint64(0)
    shown, left = pointer(keys), pointer(hidden)
    some = hidden.shape[0] > 0
    for p in range(np.uint64(begin), np.uint64(end)):
        key = shown[p]
        places[n] = THREE * p
        numbers[n] = np.uint32(LOW - (key >> SHIFT)).view(np.float32)
        solid = (key != EMPTY) & ((key & LOW) >= FIRST)
        if some:
            solid &= left[p] == 0
        n += np.uint64(solid)
    return np.int64(n)
