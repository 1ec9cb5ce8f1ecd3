"""Bounds of the film: light of fragments and samples into a picture, and the picture's bytes."""

from __future__ import annotations

import numpy as np

from ....jit import parallel, prange
from ....simd import broadcast, load, store, triple_pointer

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
THREE = np.uint64(3)
LAST = np.float32(65535.0)


@parallel
def blend(ends, vertex, weight, along, colours, image):
    """Write the sums of fragments' light to image (P, 3).

    ends (P + 1,) int64: the fragments of each pixel; vertex (F,) uint32, weight, along (F,): of each fragment the
    vertex before it, and how far it is on the way to the next; colours (V + 1, 3), the last only as a next one.
    """
    for pixel in prange(image.shape[0]):
        light, picture = triple_pointer(colours), triple_pointer(image)
        total = broadcast(light, ZERO)
        for i in range(np.uint64(ends[pixel]), np.uint64(ends[pixel + 1])):
            v = THREE * np.uint64(vertex[i])
            far = weight[i] * along[i]
            total += (weight[i] - far) * load(light, v) + far * load(light, v + THREE)
        store(picture, THREE * np.uint64(pixel), total)


@parallel
def colour(vertex, along, colours, image):
    """Write to image (P, 3) light between two vertices that follow each other; vertex (P,) uint32, along (P,), colours
    (V + 1, 3)."""
    for pixel in prange(image.shape[0]):
        v, t, p = np.uint64(vertex[pixel]), along[pixel], np.uint64(pixel)
        for c in range(np.uint64(3)):
            near = colours[v, c]
            image[p, c] = near + t * (colours[v + np.uint64(1), c] - near)


@parallel
def develop(image, samples, curve, out):
    """Write the bytes of out (height, width, 3) by a curve (65536,) uint8 of the mean light of samples, 0 to 1, of
    image (samples * height, samples * width, 3)."""
    height, width, _ = out.shape
    share = LAST / np.float32(samples * samples)
    for y in prange(height):
        row = np.uint64(y)
        levels = np.zeros(3 * width, np.float32)
        for j in range(samples):
            line = row * np.uint64(samples) + np.uint64(j)
            if samples == 1:
                for x in range(np.uint64(width)):
                    for c in range(np.uint64(3)):
                        levels[THREE * x + c] += image[line, x, c]
            else:
                for x in range(np.uint64(width)):
                    for i in range(np.uint64(samples)):
                        for c in range(np.uint64(3)):
                            levels[THREE * x + c] += image[line, x * np.uint64(samples) + i, c]
        for x in range(np.uint64(width)):
            for c in range(np.uint64(3)):
                level = min(max(levels[THREE * x + c] * share, ZERO), LAST)
                out[row, x, c] = curve[np.uint64(np.int64(level))]
