"""Filter windows of `percentage_closer`: the texels around each point, and their weights.

The window of a point has a radius of R texels. Where R exceeds 6 texels only every second texel is read, beyond 12
every fourth, and so on to every sixteenth beyond 48, so that a window never costs more than one with R = 6. The weights
of the skipped texels fade to zero before they are skipped, so that the transition does not show.
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
"""Greatest radius, in texels that are read."""
WIDEST = SIXTEEN * MOST
"""Greatest radius, in texels of the map."""
FADED = np.float32(0.75)
"""Share of `MOST` at which every other texel begins to fade out."""


@device
def place_windows(work, n, step, least):
    """Store the window of each of the first n points; return the greatest number of columns and of rows of any window.

    A window is empty if the point is outside of the map or the radius is at most `least` texels. Columns and rows are
    `step` texels apart, or a power of two times that for a large radius.
    """
    for k in range(n):
        radius = work[RADIUS + k]
        u = work[U + k]
        v = work[V + k]
        used = (work[INSIDE + k] > ZERO) & (radius > least)
        times = ONE if radius <= MOST else TWO if radius <= TWO * MOST else FOUR
        times = times if radius <= FOUR * MOST else EIGHT if radius <= EIGHT * MOST else SIXTEEN
        stride = step * times
        share = ONE / stride
        left = -stride * floor((radius - u) * share)
        top = -stride * floor((radius - v) * share)
        work[PER + k] = ONE / radius
        work[STRIDE + k] = stride
        work[FADE + k] = max((radius / (times * MOST) - FADED) * (ONE / (ONE - FADED)), ZERO)
        work[FIRST_U + k] = left
        work[FIRST_V + k] = top
        work[LAST_U + k] = floor(u + radius) if used else left - stride
        work[LAST_V + k] = floor(v + radius) if used else top - stride
    return widest(work, n, FIRST_U, LAST_U), widest(work, n, FIRST_V, LAST_V)


@device
def floor(x):
    """Return the floor of x, in a form that LLVM vectorises."""
    whole = np.float32(np.int32(x))
    return whole - ONE if whole > x else whole


@device
def widest(work, n, first, last):
    """Return the greatest number of columns, or of rows, of any window."""
    out = ZERO
    for k in range(n):
        out = max(out, (work[last + k] - work[first + k]) / work[STRIDE + k] + ONE)
    return np.int64(out)


@device
def place_texel(work, n, row, column, size):
    """Store position and weight of the texel at this row and column of each point's window, and add the weight to
    `TOTAL`; the row `ACROSS` is −1 outside of the map. row, column: from the window's first, float32; size: texels
    along a side of the map, float32."""
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
    """Return 1 where twice `half` is odd, 0 where it is even."""
    return TWO * (half - floor(half))
