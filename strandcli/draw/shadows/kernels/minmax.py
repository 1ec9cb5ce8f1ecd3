"""The min/max shadow map (thesis §3): per texel the nearest and the farthest strand, seen from the light.

The source stores the z of a normalised vector, a cosine, and its shadows fail when the light is far. Here it is the
depth along the light's view in metres.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, function, parallel, prange
from ....simd import pointer
from ...common.kernels.numbers import HALF, ONE, ZERO
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, FOCAL, PERSPECTIVE
from ...geometry.kernels.ribbon import GREATEST_Y, LEAST_Y
from ...view.kernels.project import to_view
from ...zbuffer.kernels.lines import FIXED, PART, POINT

THREE = np.uint64(3)
SMALL = np.float32(1e-20)
NEAREST, FARTHEST = 0, 1
"""Columns of a texel: depths of the nearest and the farthest strand, metres."""
# 1 − (√e p(h) − 1) / (e − 1) as LIT − STEEP p(h)
LIT = np.float32(1 + 1 / (math.e - 1))
STEEP = np.float32(math.sqrt(math.e) / (math.e - 1))


class Steps(NamedTuple):
    """How each of `PART` segments goes from sample to sample."""

    samples: NDArray[np.int32]
    """Samples; 0 for a segment that is not in the rows."""
    x: NDArray[np.int64]
    y: NDArray[np.int64]
    """Position of the first sample, texels in fixed point."""
    step_x: NDArray[np.int64]
    step_y: NDArray[np.int64]
    """Its change from sample to sample."""
    depth: NDArray[np.float32]
    """Depth of the first sample, metres."""
    rise: NDArray[np.float32]
    """Its change from sample to sample."""


@parallel
def fill(first, screen, bands, size, far, near, texels):
    """Draw the strands' depths into a min/max map.

    screen (V, 3): x, y in texels and the depth number of `project.points`; bands: `zbuffer.kernels.raster.Bands`; far:
    depth range of an orthographic light in metres, 0 for a perspective one; near: its nearest depth, metres; texels
    (size * size, 2) float32: nearest and farthest depth, metres; (inf, −inf) where there is no strand.
    """
    for task in prange(bands.workers):
        steps = Steps(
            np.empty(PART, np.int32), np.empty(PART, np.int64), np.empty(PART, np.int64), np.empty(PART, np.int64),
            np.empty(PART, np.int64), np.empty(PART, np.float32), np.empty(PART, np.float32),
        )  # fmt: skip
        for top in range(np.int64(task) * bands.rows, size, bands.workers * bands.rows):
            band(first, screen, bands.extents, top, min(top + bands.rows, size), size, far, near, steps, texels)


@device
def band(first, screen, extents, top, bottom, size, far, near, steps, texels):
    """Draw the strands in the rows top … bottom − 1; steps: `Steps` to work in; other arguments as in `fill`."""
    for s in range(extents.shape[0]):
        if not (extents[s, LEAST_Y] < np.float32(bottom) and extents[s, GREATEST_Y] >= np.float32(top)):
            continue
        v = first[s]
        end = first[s + 1] - 1
        while v < end:
            n = min(end - v, np.int64(PART))
            prepare(screen, v, n, top, bottom, size, far, near, steps)
            for k in range(n):
                if steps.samples[k] > 0:
                    line(k, steps, top, bottom, size, texels)
            v += n


@device
def prepare(screen, begin, n, top, bottom, size, far, near, steps):
    """Write the steps of the n segments from vertex `begin` on, side by side without branches, which LLVM vectorises:
    a sample for each texel along the longer axis, and at least one."""
    points = pointer(screen)
    above, below, most = np.float32(top), np.float32(bottom), np.float32(4 * size)
    for k in range(n):
        o = THREE * np.uint64(begin + k)
        x0, y0, q0 = points[o], points[o + np.uint64(1)], points[o + np.uint64(2)]
        x1, y1, q1 = points[o + np.uint64(3)], points[o + np.uint64(4)], points[o + np.uint64(5)]
        length = np.ceil(max(abs(x1 - x0), abs(y1 - y0)))
        inside = (max(y0, y1) >= above) & (min(y0, y1) < below)
        # where the light is so near that a segment is longer than its map, it is left out
        some = (q0 > ZERO) & (q1 > ZERO) & inside & (length <= most)
        d0 = near + (ONE - q0) * far if far > ZERO else ONE / q0
        d1 = near + (ONE - q1) * far if far > ZERO else ONE / q1
        count = max(length, ONE)
        per = ONE / count
        rise = (d1 - d0) * per
        steps.samples[k] = np.int32(count if some else ZERO)
        steps.x[k] = np.int64((x0 + (x1 - x0) * per * HALF) * FIXED if some else ZERO)
        steps.y[k] = np.int64((y0 + (y1 - y0) * per * HALF) * FIXED if some else ZERO)
        steps.step_x[k] = np.int64((x1 - x0) * per * FIXED if some else ZERO)
        steps.step_y[k] = np.int64((y1 - y0) * per * FIXED if some else ZERO)
        steps.depth[k] = d0 + rise * HALF
        steps.rise[k] = rise


@device
def line(k, steps, top, bottom, size, texels):
    """Draw the samples of segment number k."""
    d, rise = steps.depth[k], steps.rise[k]
    x, y, step_x, step_y = steps.x[k], steps.y[k], steps.step_x[k], steps.step_y[k]
    for _ in range(np.int64(steps.samples[k])):
        row = y >> POINT
        column = x >> POINT
        if row >= top and row < bottom and column >= 0 and column < size:
            t = np.uint64(row * size + column)
            texels[t, NEAREST] = min(texels[t, NEAREST], d)
            texels[t, FARTHEST] = max(texels[t, FARTHEST], d)
        x += step_x
        y += step_y
        d += rise


@device
def texel_of(point, views, one):
    """Return column, row and depth (metres) of a point in map number `one`; columns and rows are integers at texel
    centres."""
    sx, sy, d = to_view(point[0], point[1], point[2], views[one])
    scale = views[one, FOCAL] / d if views[one, PERSPECTIVE] > ZERO else views[one, FOCAL]
    return views[one, AXIS_X] + scale * sx - HALF, views[one, AXIS_Y] - scale * sy - HALF, d


@device
def bilinear(u, v, one, right, below, corner):
    """Interpolate bilinearly between four texels."""
    upper = one + u * (right - one)
    lower = below + u * (corner - below)
    return upper + v * (lower - upper)


@function
def falloff(d, r, a):
    """Return 1 − (eˣ − 1) / (e − 1), x = (d − r) / (a − r), at depth d between the nearest depth r and the farthest a.

    Where a = r: 1 in front, 0 behind. Empty texels, with r = inf and a = −inf, give 1. eˣ is its Taylor polynomial of
    degree 6 about 1/2; error 2e-6 on [0, 1].
    """
    x = min(max((d - r) / max(a - r, SMALL), ZERO), ONE)
    h = x - HALF
    e = ONE + h * np.float32(1 / 6)
    e = ONE + h * np.float32(1 / 5) * e
    e = ONE + h * np.float32(1 / 4) * e
    e = ONE + h * np.float32(1 / 3) * e
    e = ONE + h * HALF * e
    e = ONE + h * e
    return min(max(LIT - STEEP * e, ZERO), ONE)
