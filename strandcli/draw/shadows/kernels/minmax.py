"""The min/max shadow map (thesis §3): per texel the nearest and the farthest strand, seen from the light.

The source stores the z of a normalised vector, a cosine, and its shadows fail when the light is far. Here it is the
depth along the light's view in metres.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, function, parallel, prange
from ...common.kernels.light_columns import BIAS, FIRST_MAP, MAP_COUNT
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, FOCAL, NEAR_PLANE, PERSPECTIVE
from ...view.kernels.project import to_view_number
from ...zbuffer.kernels.raster import FIXED, POINT

HALF = np.float32(0.5)
ZERO = np.float32(0.0)
ONE = np.float32(1.0)
NEXT = np.uint64(1)
SMALL = np.float32(1e-20)
NEAREST, FARTHEST = 0, 1
"""Columns of a texel: depths of the nearest and the farthest strand, metres."""
# 1 − (√e p(h) − 1) / (e − 1) as LIT − STEEP p(h)
LIT = np.float32(1 + 1 / (math.e - 1))
STEEP = np.float32(math.sqrt(math.e) / (math.e - 1))


@parallel
def fill(first, screen, members, begin, size, rows, workers, far, near, texels):
    """Draw the strands' depths into a min/max map.

    screen (V, 3): x, y in texels and the depth number of `project.points`; far: depth range of an orthographic light in
    metres, 0 for a perspective one; near: its nearest depth, metres; members, begin, rows, workers: `bands.Bands`;
    texels (size * size, 2) float32: nearest and farthest depth, metres; (inf, −inf) where there is no strand.
    """
    for task in prange(workers):
        for b in range(task, begin.shape[0] - 1, workers):
            band(first, screen, members, begin, b, size, rows, far, near, texels)


@device
def band(first, screen, members, begin, b, size, rows, far, near, texels):
    """Draw the strands of band number `b`; arguments as in `fill`."""
    top = b * rows
    bottom = min(top + rows, size)
    for m in range(begin[b], begin[b + 1]):
        s = members[m]
        a = first[s]
        x1 = screen[a, 0]
        y1 = screen[a, 1]
        q1 = screen[a, 2]
        for v in range(a + 1, first[s + 1]):
            x0 = x1
            y0 = y1
            q0 = q1
            x1 = screen[v, 0]
            y1 = screen[v, 1]
            q1 = screen[v, 2]
            if max(y0, y1) < np.float32(top) or min(y0, y1) >= np.float32(bottom) or q0 <= ZERO or q1 <= ZERO:
                continue
            d0 = near + (ONE - q0) * far if far > ZERO else ONE / q0
            d1 = near + (ONE - q1) * far if far > ZERO else ONE / q1
            line(x0, y0, d0, x1, y1, d1, top, bottom, size, texels)


@function
def line(x0, y0, d0, x1, y1, d1, top, bottom, size, texels):
    """Draw one segment: a sample for each texel along its longer axis, and at least one."""
    length = np.ceil(max(abs(x1 - x0), abs(y1 - y0)))
    if length > np.float32(4 * size):  # the light is so near that a segment is longer than its map
        return
    steps = max(length, ONE)
    per = ONE / steps
    rise = (d1 - d0) * per
    d = d0 + rise * HALF
    x = np.int64((x0 + (x1 - x0) * per * HALF) * FIXED)
    y = np.int64((y0 + (y1 - y0) * per * HALF) * FIXED)
    step_x = np.int64((x1 - x0) * per * FIXED)
    step_y = np.int64((y1 - y0) * per * FIXED)
    for _ in range(np.int64(steps)):
        row = y >> POINT
        column = x >> POINT
        if row >= top and row < bottom and column >= 0 and column < size:
            t = np.uint64(row * size + column)
            texels[t, NEAREST] = min(texels[t, NEAREST], d)
            texels[t, FARTHEST] = max(texels[t, FARTHEST], d)
        x += step_x
        y += step_y
        d += rise


@function
def transmittance(x, y, z, lights, i, maps, starts, sizes, views):
    """Return the share of light number i that reaches a point, 0 to 1; 1 where the point is outside of all its maps.

    x = (d − r) / (a − r) (the source prints its inverse), y = (eˣ − 1) / (e − 1), transmittance 1 − y (thesis §3),
    interpolated bilinearly between four texels. x, y, z: metres; lights (n, `light_columns.COLUMNS`); maps, starts,
    sizes, views: `texels` … of `ShadowArrays`.
    """
    for one in range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT])):
        u, v, d = texel_of(x, y, z, views, one)
        if not in_map(u, v, d, views, one, np.float32(sizes[one] - 1)):
            continue
        low_u = np.floor(u)
        low_v = np.floor(v)
        texel = np.uint64(starts[one] + np.int64(low_v) * sizes[one] + np.int64(low_u))
        below = texel + np.uint64(sizes[one])
        upper = max(maps[texel, FARTHEST], maps[texel + NEXT, FARTHEST])
        farthest = max(upper, max(maps[below, FARTHEST], maps[below + NEXT, FARTHEST]))
        if farthest < ZERO:  # no strand in any of the four
            return ONE
        d -= lights[i, BIAS]
        return bilinear(
            u - low_u, v - low_v,
            falloff(d, maps[texel, NEAREST], maps[texel, FARTHEST]),
            falloff(d, maps[texel + NEXT, NEAREST], maps[texel + NEXT, FARTHEST]),
            falloff(d, maps[below, NEAREST], maps[below, FARTHEST]),
            falloff(d, maps[below + NEXT, NEAREST], maps[below + NEXT, FARTHEST]),
        )  # fmt: skip
    return ONE


@device
def texel_of(x, y, z, views, one):
    """Return column, row and depth (metres) of a point in map number `one`; columns and rows are integers at texel
    centres."""
    sx, sy, d = to_view_number(x, y, z, views, one)
    scale = views[one, FOCAL] / d if views[one, PERSPECTIVE] > ZERO else views[one, FOCAL]
    return views[one, AXIS_X] + scale * sx - HALF, views[one, AXIS_Y] - scale * sy - HALF, d


@device
def in_map(u, v, d, views, one, edge):
    """Return whether a point lies between four texels of a map. The outermost texels are empty, so points beyond them
    are lit. edge: texels along a side − 1."""
    return (d >= views[one, NEAR_PLANE]) & (u >= ZERO) & (v >= ZERO) & (u < edge) & (v < edge)


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
