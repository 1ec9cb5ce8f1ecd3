"""The texels about points over which `percentage_closer` averages, and their weights.

The window of a point reaches R texels to each side. Where R is more than six texels only every second one is read,
every fourth at more than twelve, and so on to every sixteenth at more than 48, so that no window costs more than one
of six. The others fade out before, so that no step shows where they go.
"""

from __future__ import annotations

import numpy as np

from ....jit import device
from ...common.kernels.batch import INSIDE, U, V
from ...common.kernels.surface_batch import (
    ACROSS,
    DOWN,
    FADE,
    FIRST_U,
    FIRST_V,
    LAST_U,
    LAST_V,
    PER,
    RADIUS,
    STRIDE,
    TOTAL,
    WEIGHT,
)

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
FOUR = np.float32(4.0)
EIGHT = np.float32(8.0)
SIXTEEN = np.float32(16.0)
MOST = np.float32(6.0)
"""Texels to each side that are read."""
WIDEST = SIXTEEN * MOST
"""Texels to each side over which a light is averaged at the most."""
FADED = np.float32(0.75)
"""Of `MOST`, from where on every other texel fades out."""


@device
def place_windows(work, n, step, least):
    """Store the window of each point, and return the greatest number of columns and of rows that any has.

    Windows of points that the map does not hold, or whose radius is no more than `least` texels, are empty. Their
    columns and rows are multiples of `step` texels, or of a multiple of that where the radius is large.
    """
    for k in range(n):
        radius = work[RADIUS + k]
        u = work[U + k]
        v = work[V + k]
        asked = (work[INSIDE + k] > ZERO) & (radius > least)
        times = ONE if radius <= MOST else TWO if radius <= TWO * MOST else FOUR
        times = times if radius <= FOUR * MOST else EIGHT if radius <= EIGHT * MOST else SIXTEEN
        stride = step * times
        share = ONE / stride
        left = -stride * below((radius - u) * share)
        top = -stride * below((radius - v) * share)
        work[PER + k] = ONE / radius
        work[STRIDE + k] = stride
        work[FADE + k] = max((radius / (times * MOST) - FADED) * (ONE / (ONE - FADED)), ZERO)
        work[FIRST_U + k] = left
        work[FIRST_V + k] = top
        work[LAST_U + k] = below(u + radius) if asked else left - stride
        work[LAST_V + k] = below(v + radius) if asked else top - stride
    return widest(work, n, FIRST_U, LAST_U), widest(work, n, FIRST_V, LAST_V)


@device
def below(x):
    """The greatest whole number that is no greater than x, in a form that LLVM vectorises."""
    whole = np.float32(np.int32(x))
    return whole - ONE if whole > x else whole


@device
def widest(work, n, first, last):
    """The greatest number of columns, or of rows, of any window."""
    out = ZERO
    for k in range(n):
        out = max(out, (work[last + k] - work[first + k]) / work[STRIDE + k] + ONE)
    return np.int64(out)


@device
def place_texel(work, n, row, column, size):
    """Store the place and weight of the texel in this row and column of each point's window, and add the weight to
    `TOTAL`. row, column: counted from the window's first; size: texels a side of the map. All float32."""
    for k in range(n):
        stride = work[STRIDE + k]
        across = work[FIRST_U + k] + column * stride
        down = work[FIRST_V + k] + row * stride
        there = (across <= work[LAST_U + k]) & (down <= work[LAST_V + k])
        held = there & (across >= ZERO) & (down >= ZERO) & (across < size) & (down < size)
        work[ACROSS + k] = across if held else -ONE
        work[DOWN + k] = down
        share = HALF / stride
        fade = work[FADE + k]
        thin = (ONE - fade * odd(across * share)) * (ONE - fade * odd(down * share))
        across = (across - work[U + k]) * work[PER + k]
        across = ONE - across * across
        down = (down - work[V + k]) * work[PER + k]
        down = ONE - down * down
        weight = thin * down * down * across * across if there else ZERO
        work[WEIGHT + k] = weight
        work[TOTAL + k] += weight


@device
def odd(half):
    """1 where twice this number is odd, 0 where it is even."""
    return TWO * (half - below(half))
