"""Noise that hides the steps of 8-bit levels in the light of solids, as in that of the backdrop (`film.dithered`)."""

from __future__ import annotations

import numpy as np

from ....jit import device, function, inlined
from ....simd import floor, gather, where
from .numbers import HALF, ONE, ZERO

MOST = np.float32(1e6)
BITS = np.float32(2.0**-24)
SAMPLES, CORNER_X, CORNER_Y, EXPOSURE, PER_EXPOSURE = range(5)
"""Columns of a frame: samples along a side of a pixel; position in the full picture, pixels; scale of light, and its
inverse."""


@function
def noise(x, y):
    """Return noise in [−½, ½) of a pixel of the full picture, by its position alone (Wellons's `lowbias32` hash)."""
    bits = np.uint32(np.uint32(x) + np.uint32(0x9E3779B9) * np.uint32(y))
    bits = np.uint32((bits ^ (bits >> np.uint32(16))) * np.uint32(0x7FEB352D))
    bits = np.uint32((bits ^ (bits >> np.uint32(15))) * np.uint32(0x846CA68B))
    bits = np.uint32(bits ^ (bits >> np.uint32(16)))
    return np.float32(bits >> np.uint32(8)) * BITS - HALF


@device
def noise_at(column, row, frame):
    """Return the noise of the pixel that holds a sample; frame: its columns."""
    x, y = np.uint32(column), np.uint32(row)
    samples = np.uint32(frame[SAMPLES])
    if samples > np.uint32(1):
        x, y = x // samples, y // samples
    return noise(x + np.uint32(frame[CORNER_X]), y + np.uint32(frame[CORNER_Y]))


@inlined
def dithered(light, share, levels, count, frame):
    """Return light with `share` of an 8-bit level more. Vectors; levels: pointer to the `count` of `film.level_sizes`;
    frame: its columns."""
    exposed = light * frame[EXPOSURE]
    some = (exposed > ZERO) & (exposed < MOST)
    exposed = where(some, exposed, ZERO)
    step = gather(levels, 0, floor(exposed / (ONE + exposed) * np.float32(count)), np.int64(1), ZERO)
    return where(some, max(light + share * step * frame[PER_EXPOSURE], ZERO), light)
