"""Film: vertices to shade, colours of samples, and conversion to 8 bits."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....jit import device, function, inlined, parallel, prange
from ....simd import pointer, prefetch
from ...common.kernels.approximations import exp2
from ...common.kernels.keys import EMPTY, FIRST, LOW, SHIFT
from ...common.kernels.numbers import HALF, ONE, ZERO

LAST = np.float32(65535.0)
MOST = np.float32(1e30)
ONE_ON, THREE, FOUR, FIVE = np.uint64(1), np.uint64(3), np.uint64(4), np.uint64(5)
PART = 1024
"""Pixels that are listed at once."""
AHEAD = 24
"""Pixels whose vertices are fetched before their turn: they lie wherever their strands do."""


@function
def mark(keys, base, count, per, stride, listed, marks):
    """Mark the vertices to shade: the ends of all visible segments. Return the number of pixels that show one.

    keys (P,) uint64; base: number of vertex 0 in the keys; count: number of vertices; per: vertices a strand if all
    strands have the same number, else 0; stride: every stride-th vertex of a strand is shaded, 1 if per is 0; listed
    (3, `PART`) int32: to work in; marks (count,) uint8: initially zero.
    """
    columns, vertices, past = listed[0], listed[1], listed[2]
    seen = np.int64(0)
    for begin in range(0, keys.shape[0], PART):
        end = min(begin + PART, keys.shape[0])
        n = find_strands(keys, np.uint64(begin), np.uint64(end - begin), base, count, columns, vertices)
        find_past(vertices, n, per, stride, past)
        for k in range(n):
            v = np.uint64(vertices[k] - past[k] if stride > 1 else vertices[k])
            marks[v] = 1
            marks[v + np.uint64(stride)] = 1
        seen += np.int64(n)
    return seen


@device
def find_strands(keys, first, width, base, count, columns, vertices):
    """List which of the keys first … first + width − 1 show one of `count` vertices, and its number; return how many.

    Without branches, so that memory accesses of one pixel overlap with the arithmetic of the next.
    """
    last = np.uint64(max(count - 1, 0))  # 0 without vertices, which excludes every pixel
    shown = pointer(keys)
    n = np.uint64(0)
    for x in range(width):
        v = (shown[first + x] & LOW) - np.uint64(base)
        columns[n] = x
        vertices[n] = np.int32(v)
        n += np.uint64(v < last)
    return n


@device
def find_past(vertices, n, per, stride, past):
    """Write how far each of n vertices is past a shaded one. Quotients of halves cannot come near a whole number, so
    that those in double precision are exact; they take vectors, which whole numbers do not."""
    if stride > 1:
        strand, part = 1.0 / np.float64(per), 1.0 / np.float64(stride)
        for k in range(n):
            v = vertices[k]
            v -= np.int32((np.float64(v) + 0.5) * strand) * np.int32(per)
            past[k] = v - np.int32((np.float64(v) + 0.5) * part) * np.int32(stride)


@parallel
def colours(keys, base, screen, per, stride, vertex, image):
    """Write the colour of visible strands, interpolated between shaded vertices, to the image (height, width, 3).

    keys (height * width,) uint64; base, per, stride: as in `mark`; screen (V, 3): projected vertices; vertex (V, 3):
    radiance at shaded vertices.
    """
    height, width, _ = image.shape
    share = ONE / np.float32(stride)
    up = THREE * np.uint64(stride)
    points, radiance, picture = pointer(screen), pointer(vertex), image.reshape(-1)
    for y in prange(height):
        first = np.uint64(y * width)
        columns, past = np.empty(width, np.int32), np.empty(width, np.int32)
        vertices = np.zeros(width + AHEAD, np.int32)  # those ahead of the last are some vertex
        n = find_strands(keys, first, np.uint64(width), base, screen.shape[0], columns, vertices)
        find_past(vertices, n, per, stride, past)
        across = np.float32(y) + HALF
        for k in range(n):
            soon = THREE * np.uint64(vertices[k + np.uint64(AHEAD)])
            prefetch(points, soon)
            prefetch(points, soon + FOUR)
            prefetch(radiance, soon - THREE)
            prefetch(radiance, soon + FIVE)
            x, v = columns[k], THREE * np.uint64(vertices[k])
            x0, y0 = points[v], points[v + ONE_ON]
            dx = points[v + THREE] - x0
            dy = points[v + FOUR] - y0
            flat = abs(dx) >= abs(dy)
            step = dx if flat else dy
            t = (np.float32(x) + HALF - x0 if flat else across - y0) / (step if step != ZERO else ONE)
            t = min(max(t, ZERO), ONE)
            if stride > 1:
                v -= THREE * np.uint64(past[k])
                t = (np.float32(past[k]) + t) * share
            at = THREE * (first + np.uint64(x))
            for c in range(THREE):
                picture[at + c] = radiance[v + c] + t * (radiance[v + up + c] - radiance[v + c])


@parallel
def develop(image, samples, exposure, curve, roll, out):
    """Average squares of samples × samples, and convert them to 8 bits.

    image (samples * height, samples * width, 3) linear; exposure: factor; curve (65536,) uint8 over light x in [0, 1]
    if `roll` is 0, or over x / (1 + x) if it is 1; out (height, width, 3) uint8. NaN becomes black.
    """
    height, width, _ = out.shape
    share = exposure / np.float32(samples * samples) * LAST
    flat = pointer(image)
    for y in prange(height):
        row = np.int64(y)
        levels = np.empty(3 * width, np.float32)
        if samples == 1:
            begin = np.uint64(row * 3 * width)
            for i in range(np.uint64(3 * width)):
                levels[i] = flat[begin + i]
        else:
            for x in range(width):
                for c in range(3):
                    total = ZERO
                    for j in range(samples):
                        for i in range(samples):
                            total += image[row * samples + j, x * samples + i, c]
                    levels[3 * x + c] = total
        encode(levels, share, roll / LAST)
        for x in range(np.uint64(width)):
            for c in range(np.uint64(3)):
                out[row, x, c] = curve[np.uint64(np.int64(levels[THREE * x + c]))]


@device
def encode(levels, share, roll):
    """Replace light by indices into the tone curve, rounded and clamped to 0 … 65535."""
    for i in range(np.uint64(levels.shape[0])):
        value = levels[i] * share
        value = value if value > ZERO else ZERO
        value = min(value, MOST)
        value /= ONE + roll * value
        levels[i] = min(value, LAST) + HALF


NEAREST = np.float32(1e-12)
"""Least depth number of a perspective view, 1 / metres."""


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


@device
def arrives(air, number):
    """Return the share of light that arrives from a depth number."""
    if air.perspective > ZERO:
        return exp2(ONE / max(NEAREST, number) * air.rate)
    return exp2(max(ZERO, air.near + (ONE - number) * air.reach) * air.rate)


@parallel
def veil_strands(air, backdrop, screen, marks, colours, slots, profile):
    """Blend the colours (V, 3) of vertices with marks (V,) with the backdrop (height, width, 3) behind them, and scale
    their width profiles alike.

    air: `Air`; screen (V, 3); slots (V,) int32: number of each vertex's profile, or −1, (0,): none has one; profile
    (profiles, columns, 3).
    """
    right, bottom = np.float32(backdrop.shape[1] - 1), np.float32(backdrop.shape[0] - 1)
    for v in prange(marks.shape[0]):
        if marks[v] == 0:
            continue
        share = arrives(air, screen[v, 2])
        x, y = inside(screen[v, 0], right), inside(screen[v, 1], bottom)
        for c in range(3):
            colours[v, c] = backdrop[y, x, c] + share * (colours[v, c] - backdrop[y, x, c])
        if slots.shape[0] > 0 and slots[v] >= 0:
            for j in range(profile.shape[1]):
                for c in range(3):
                    profile[slots[v], j, c] *= share


@inlined
def inside(x, last):
    """Return the pixel at a position, the nearest of 0 … last; the first for one that is no number."""
    return np.int64(min(x if x > ZERO else ZERO, last))


@parallel
def veil_solids(air, behind, keys, hidden, light):
    """Blend the solids of a picture, light (P, 3), with what is behind them (P, 3); keys (P,): z-buffer; hidden (P,):
    not 0 at pixels that are left as they are, (0,): none are."""
    for p in prange(keys.shape[0]):
        key = keys[p]
        if key == EMPTY or (key & LOW) < FIRST or (hidden.shape[0] > 0 and hidden[p] != 0):
            continue
        share = arrives(air, np.uint32(LOW - (key >> SHIFT)).view(np.float32))
        for c in range(3):
            light[p, c] = behind[p, c] + share * (light[p, c] - behind[p, c])
