"""Film: vertices to shade, colours of samples, and conversion to 8 bits."""

from __future__ import annotations

import numpy as np

from ....jit import device, function, parallel, prange
from ....simd import pointer
from ...common.kernels.keys import EMPTY, LOW

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
LAST = np.float32(65535.0)
MOST = np.float32(1e30)
THREE = np.uint64(3)


@function
def mark(keys, base, count, per, stride, marks):
    """Mark the vertices to shade: the ends of all visible segments. Return the number of pixels that show one.

    keys (P,) uint64; base: number of vertex 0 in the keys; count: number of vertices; per: vertices a strand if all
    strands have the same number, else 0; stride: every stride-th vertex of a strand is shaded, 1 if per is 0; marks
    (count,) uint8: initially zero.
    """
    seen = 0
    for p in range(keys.shape[0]):
        if keys[p] != EMPTY:
            v = np.int64(keys[p] & LOW) - base
            if 0 <= v < count - 1:
                if stride > 1:
                    v -= np.int64((np.uint32(v) % np.uint32(per)) % np.uint32(stride))
                marks[v] = 1
                marks[v + stride] = 1
                seen += 1
    return seen


@parallel
def colours(keys, base, screen, per, stride, vertex, image):
    """Write the colour of visible strands, interpolated between shaded vertices, to the image (height, width, 3).

    keys (height * width,) uint64; base, per, stride: as in `mark`; screen (V, 3): projected vertices; vertex (V, 3):
    radiance at shaded vertices.
    """
    height, width, _ = image.shape
    last = np.uint64(max(screen.shape[0] - 1, 0))  # 0 without vertices, which excludes every pixel
    share = ONE / np.float32(stride)
    for y in prange(height):
        # list the pixels first: without branches, memory accesses of one pixel overlap with the arithmetic of others
        columns = np.empty(width, np.int64)
        vertices = np.empty(width, np.int64)
        n = 0
        for x in range(width):
            v = (keys[y * width + x] & LOW) - np.uint64(base)
            columns[n] = x
            vertices[n] = np.int64(v)
            n += np.int64(v < last)
        across = np.float32(y) + HALF
        for k in range(n):
            x = columns[k]
            v = vertices[k]
            x0 = screen[v, 0]
            y0 = screen[v, 1]
            dx = screen[v + 1, 0] - x0
            dy = screen[v + 1, 1] - y0
            flat = abs(dx) >= abs(dy)
            way = dx if flat else dy
            t = (np.float32(x) + HALF - x0 if flat else across - y0) / (way if way != ZERO else ONE)
            t = min(max(t, ZERO), ONE)
            if stride > 1:
                past = np.int64((np.uint32(v) % np.uint32(per)) % np.uint32(stride))
                v -= past
                t = (np.float32(past) + t) * share
            for c in range(3):
                image[y, x, c] = vertex[v, c] + t * (vertex[v + stride, c] - vertex[v, c])


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
            add_up(image, samples, row, width, levels)
        encode(levels, share, roll / LAST)
        for x in range(np.uint64(width)):
            for c in range(np.uint64(3)):
                out[row, x, c] = curve[np.uint64(np.int64(levels[THREE * x + c]))]


@device
def add_up(image, samples, y, width, levels):
    """Write the sums of the samples of each pixel of row y to levels (3 * width,)."""
    for x in range(width):
        for c in range(3):
            total = ZERO
            for j in range(samples):
                for i in range(samples):
                    total += image[y * samples + j, x * samples + i, c]
            levels[3 * x + c] = total


@device
def encode(levels, share, roll):
    """Replace light by indices into the tone curve, rounded and clamped to 0 … 65535."""
    for i in range(np.uint64(levels.shape[0])):
        value = levels[i] * share
        value = value if value > ZERO else ZERO
        value = min(value, MOST)
        value /= ONE + roll * value
        levels[i] = min(value, LAST) + HALF
