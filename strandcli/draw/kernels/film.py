"""From what is seen in each sample to the picture."""

from __future__ import annotations

import numpy as np

from ...jit import function, parallel, prange
from .raster import EMPTY, LOW

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
LAST = np.float32(65535.0)


@parallel
def colours(keys, base, screen, per, stride, vertex, image):
    """Colour of the strands that are seen, linear between two lit vertices.

    keys (height * width,) uint64; base: number that was added to vertex indices; screen (V, 3) as projected; vertex
    (V, 3) radiance at lit vertices; per, stride: which these are, as in `shade.mark`; image (height, width, 3).
    """
    height, width, _ = image.shape
    count = screen.shape[0]
    for y in prange(height):
        for x in range(width):
            key = keys[y * width + x]
            if key == EMPTY:
                continue
            v = np.int64(key & LOW) - base
            if not 0 <= v < count - 1:
                continue
            dx = screen[v + 1, 0] - screen[v, 0]
            dy = screen[v + 1, 1] - screen[v, 1]
            if abs(dx) >= abs(dy):
                t = (np.float32(x) + HALF - screen[v, 0]) / dx if dx != ZERO else ZERO
            else:
                t = (np.float32(y) + HALF - screen[v, 1]) / dy
            t = min(max(t, ZERO), ONE)
            if stride > 1:
                past = (v % per) % stride
                v -= past
                t = (np.float32(past) + t) / np.float32(stride)
            for c in range(3):
                image[y, x, c] = vertex[v, c] + t * (vertex[v + stride, c] - vertex[v, c])


@parallel
def develop(image, samples, exposure, curve, out):
    """Average samples × samples squares and encode.

    image (samples * height, samples * width, 3) linear; exposure: factor; curve (65536,) uint8, the transfer function
    of [0, 1]; out (height, width, 3) uint8. What is not a number is drawn as black, never cast.
    """
    height, width, _ = out.shape
    share = exposure / np.float32(samples * samples) * LAST
    for y in prange(height):
        if samples == 1:
            for x in range(width):
                for c in range(3):
                    out[y, x, c] = encode(image[y, x, c] * share, curve)
            continue
        for x in range(width):
            for c in range(3):
                total = ZERO
                for j in range(samples):
                    for i in range(samples):
                        total += image[y * samples + j, x * samples + i, c]
                out[y, x, c] = encode(total * share, curve)


@function
def encode(value, curve):
    """The curve at a value of 0 to 65535; beyond that range, at its end."""
    value = value if value > ZERO else ZERO
    return curve[np.uint64(min(value, LAST) + HALF)]
