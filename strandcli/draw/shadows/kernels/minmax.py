"""The min/max shadow map (thesis §3): per texel the nearest and the farthest strand, seen from the light.

The source stores the z of a normalised vector, a cosine, and its shadows fail when the light is far. Here it is the
depth along the light's view in metres.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, function, parallel, prange
from ...common.kernels.numbers import HALF, ONE, ZERO
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, FOCAL, PERSPECTIVE
from ...geometry.kernels.ribbon import GREATEST_Y, LEAST_Y
from ...view.kernels.project import to_view
from ...zbuffer.kernels.lines import FIXED, POINT

SMALL = np.float32(1e-20)
NEAREST, FARTHEST = 0, 1
"""Columns of a texel: depths of the nearest and the farthest strand, metres."""
# 1 − (√e p(h) − 1) / (e − 1) as LIT − STEEP p(h)
LIT = np.float32(1 + 1 / (math.e - 1))
STEEP = np.float32(math.sqrt(math.e) / (math.e - 1))


@parallel
def fill(first, screen, bands, size, far, near, texels):
    """Draw the strands' depths into a min/max map.

    screen (V, 3): x, y in texels and the depth number of `project.points`; bands: `zbuffer.kernels.raster.Bands`; far:
    depth range of an orthographic light in metres, 0 for a perspective one; near: its nearest depth, metres; texels
    (size * size, 2) float32: nearest and farthest depth, metres; (inf, −inf) where there is no strand.
    """
    for task in prange(bands.workers):
        for top in range(np.int64(task) * bands.rows, size, bands.workers * bands.rows):
            bottom = min(top + bands.rows, size)
            for s in range(bands.extents.shape[0]):
                if bands.extents[s, LEAST_Y] < np.float32(bottom) and bands.extents[s, GREATEST_Y] >= np.float32(top):
                    for v in range(first[s], first[s + 1] - 1):
                        line(screen, v, top, bottom, size, far, near, texels)


@device
def line(screen, v, top, bottom, size, far, near, texels):
    """Draw the segment from vertex v to the next in the rows top … bottom − 1, with a sample for each texel along its
    longer axis, and at least one; other arguments as in `fill`."""
    x0, y0, q0 = screen[v, 0], screen[v, 1], screen[v, 2]
    x1, y1, q1 = screen[v + 1, 0], screen[v + 1, 1], screen[v + 1, 2]
    dx, dy = x1 - x0, y1 - y0
    inside = max(y0, y1) >= np.float32(top) and min(y0, y1) < np.float32(bottom)
    length = np.ceil(max(abs(dx), abs(dy)))
    # where the light is so near that a segment is longer than its map, it is left out
    if not (inside and min(q0, q1) > ZERO and length <= np.float32(4 * size)):
        return
    d = near + (ONE - q0) * far if far > ZERO else ONE / q0
    end = near + (ONE - q1) * far if far > ZERO else ONE / q1
    per = ONE / max(length, ONE)
    rise = (end - d) * per
    d += rise * HALF
    x, y = np.int64((x0 + dx * per * HALF) * FIXED), np.int64((y0 + dy * per * HALF) * FIXED)
    step_x, step_y = np.int64(dx * per * FIXED), np.int64(dy * per * FIXED)
    for _ in range(np.int64(max(length, ONE))):
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
