"""Rasterisation of lines one pixel wide.

A line draws one sample a pixel along its longer axis, where that axis crosses the pixel's centre:

        .   .   .   .            a polyline's joints are drawn once,
      x---o . | .   .            because each segment covers the half-
        .   o---o---x            open range of centres between its ends

What a segment's samples share is computed first, for the segments of a strand side by side in loops without branches,
which LLVM vectorises; then its samples are drawn, which are three or so.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device
from ....simd import pointer
from ...common.kernels.keys import LOW, SHIFT
from ...common.kernels.numbers import HALF, ONE, ZERO

POINT = 24
"""Bits after the point of fixed-point positions."""
FIXED = np.float32(2.0**POINT)
PART = 64
"""Segments that are prepared at once."""
THREE = np.uint64(3)


class Window(NamedTuple):
    """The rows top <= y < bottom of a picture."""

    top: int
    bottom: int
    width: int
    """Of the picture, pixels."""


class Steps(NamedTuple):
    """How each of `PART` segments goes from sample to sample along its longer axis."""

    low: NDArray[np.int32]
    """First column in the window, or first row of a steep segment."""
    samples: NDArray[np.int32]
    """Samples in the window along that axis."""
    past: NDArray[np.int32]
    """Samples before the first that are on the screen."""
    wide: NDArray[np.int32]
    """1 if the longer axis is x, 0 if it is y."""
    place: NDArray[np.int64]
    """Position across at the first sample on the screen, pixels in fixed point."""
    step: NDArray[np.int64]
    """Its change from sample to sample."""
    depth: NDArray[np.float32]
    """Depth number at the first sample on the screen."""
    rise: NDArray[np.float32]
    """Its change from sample to sample."""


@device
def draw_lines(screen, begin, end, window, base, steps, keys):
    """Draw the segments of the strand begin … end − 1 into the rows of a `Window`; steps: `Steps` to work in; base:
    number added to a vertex index in the key."""
    v = begin
    while v < end - 1:
        n = min(end - 1 - v, np.int64(PART))
        prepare(screen, v, n, window, steps)
        for k in range(n):
            if steps.samples[k] > 0:
                draw_line(k, steps, window, np.uint64(base + v + k), keys)
        v += n


@device
def prepare(screen, begin, n, window, steps):
    """Write the steps of the n segments from vertex `begin` on.

    The longer axis, and the end that comes first along it, are chosen without branches. Positions across are in fixed
    point and step from the first centre on the screen, so that they do not depend on the window.
    """
    points = pointer(screen)
    above, below, beyond = np.float32(window.top), np.float32(window.bottom), np.float32(window.width)
    for k in range(n):
        o = THREE * np.uint64(begin + k)
        x0, y0, q0 = points[o], points[o + np.uint64(1)], points[o + np.uint64(2)]
        x1, y1, q1 = points[o + np.uint64(3)], points[o + np.uint64(4)], points[o + np.uint64(5)]
        wide = abs(x1 - x0) >= abs(y1 - y0)
        a0 = x0 if wide else y0
        b0 = y0 if wide else x0
        a1 = x1 if wide else y1
        b1 = y1 if wide else x1
        back = a1 < a0
        first = a1 if back else a0
        last = a0 if back else a1
        across = b1 if back else b0
        start = max(np.ceil(first - HALF), ZERO)
        high = min(np.ceil(last - HALF), beyond if wide else below)
        low = max(start, ZERO if wide else above)
        inside = (max(y0, y1) >= above) & (min(y0, y1) < below)
        some = (q0 > ZERO) & (q1 > ZERO) & inside & (low < high)
        per = ONE / (a1 - a0)
        slope = (b1 - b0) * per
        rise = (q1 - q0) * per
        at = start + HALF - first
        steps.low[k] = np.int32(low if some else ZERO)
        steps.samples[k] = np.int32(high - low if some else ZERO)
        steps.past[k] = np.int32(low - start if some else ZERO)
        steps.wide[k] = np.int32(wide)
        steps.place[k] = np.int64((across + slope * at) * FIXED if some else ZERO)
        steps.step[k] = np.int64(slope * FIXED if some else ZERO)
        steps.depth[k] = (q1 if back else q0) + rise * at
        steps.rise[k] = rise


@device
def draw_line(k, steps, window, identity, keys):
    """Draw the samples of segment number k; identity: low half of the key."""
    top, bottom, width = window
    wide = steps.wide[k] != 0
    past = np.int64(steps.past[k])
    q, rise, step = steps.depth[k], steps.rise[k], steps.step[k]
    b = steps.place[k] + past * step
    along = 1 if wide else width
    over = width if wide else 1
    least = top if wide else 0
    most = (bottom if wide else width) - least
    at_a = np.int64(steps.low[k]) * along
    for i in range(past, past + np.int64(steps.samples[k])):
        row = b >> POINT
        if np.uint64(row - least) < np.uint64(most):
            deposit(q + rise * np.float32(i), identity, np.uint64(at_a + row * over), keys)
        at_a += along
        b += step


@device
def deposit(q, identity, pixel, keys):
    """Keep the nearer of a pixel's key and this one."""
    # rounding may make q negative, whose bits would count as near
    key = ((LOW - np.uint64(np.float32(max(q, ZERO)).view(np.uint32))) << SHIFT) | identity
    keys[pixel] = min(key, keys[pixel])  # an unconditional store, since a branch could not be predicted
