"""Shadows of strands on solids: percentage-closer filtering of deep opacity maps.

The steps between texels do not show on strands, but on a smooth surface each texel would show as a square. So the
transmittance is averaged over the texels around a point (percentage-closer filtering, Reeves, Salesin & Cook 1987),
with weights (1 − (x / R)²)² along each axis. The radius R is at least 1.5 texels, where the weights are close to a
quadratic B-spline, and more where the light has a size: a disc of the light's angular radius times D blurs the shadow
of strands at a distance D (percentage-closer soft shadows, Fernando 2005). D is the mean distance of the occluders,
weighted by their opacity, over every other texel within the blur of strands at the map's centre, or at its front for
points in its front half. So the shadow of strands that touch the skin is sharp even if the rest of the groom is far
away. Where R is large only some texels are read (`filter_window`).

Light that strands scatter leaves them in all directions and arrives beside their shadow, the more of it the farther
behind them a point is. About w / (w + g) of the light scattered by a disc falls on an equal disc at a distance g, where
w is .6 of its radius (from the view factor). Translucent is only the fringe of a groom, so w is one sixteenth of the
map's width. Without this the shadow of a coat would have a warm rim far from it, not only on the skin beneath.

On a ground under a thousand strands the mean error against rays to the whole light is .023 with the filter and .037
without it where the blur is three texels; .038 and .033 where it is one texel or less.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ....constants import W
from ....jit import device, function, inlined
from ....simd import any_lane, floor, gather, lane_count, load, pointer, sqrt, store, where
from ...common.kernels.approximations import exp_lanes
from ...common.kernels.batch import ARRIVES, DEPTH, INSIDE, U, V, X, Y, Z
from ...common.kernels.light_columns import BIAS, FIRST_MAP, KIND, LIGHT_SIZE, MAP_COUNT, MAP_LAYERS, PER_FALL
from ...common.kernels.loss import HALF_WAY
from ...common.kernels.surface_batch import AWAY, BLUR, CLOUD, LEFT, RADIUS
from ...common.kernels.view_columns import DEPTH_RANGE, FOCAL, NEAR_PLANE, PERSPECTIVE
from . import opacity
from .filter_window import WIDEST, texel_of, windows_about
from .minmax import texel_of as project

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
LEAST = np.float32(1.5)
"""Least radius of the filter, texels."""
DISC = np.float32(7.0 / 4.0)
TEXEL = np.float32(7.0 / 12.0)
"""R² of the weights, whose variance is R² / 7, with the variance of a unit disc, 1/4, and of a texel, 1/12."""
DARK = np.float32(1e-6)
FEW = np.float32(1e-3)
"""Initial weight of the mean occluder distance, for points that hardly anything occludes."""
STEP = np.float32(2.0)
"""Distance, in texels, between the texels that the occluder search reads."""
WIDE = np.float32(1 / 16)
"""w of scattered light, as a share of a map's width."""


class DeepMap(NamedTuple):
    """One opacity map."""

    rows: Any
    """`pointer` to the maps."""
    start: Any
    """First index of the map, int64."""
    size: Any
    """Texels along a side, int64."""
    layers: Any
    """int64"""
    over: Any
    """float32: 1 / h of `opacity`, 1/m."""


@function
def transmittance(work, n, lights, i, loss, stacks, starts, sizes, views):
    """Store the transmittance of light number i, in red, green and blue, at the first n points of a batch.

    Reads the rows of positions and `ARRIVES` of `surface_batch`, and writes `LEFT`, which is 1 where no light arrives.
    lights, stacks, starts, sizes, views: as in `opacity.optical_depth`; loss (m, 3): from
    `strandcli.draw.fibre.dual.loss_table`, no rows where strands absorb all colours alike, by 1 − e^-τ.
    """
    for k in range(W):
        work[INSIDE + k] = ZERO
    for k in range(3 * W):
        work[LEFT + k] = ONE
    rows = pointer(work)
    for one in range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT])):
        deep = DeepMap(
            pointer(stacks), np.int64(starts[one]), np.int64(sizes[one]), np.int64(lights[i, MAP_LAYERS]),
            lights[i, PER_FALL],
        )  # fmt: skip
        locate(work, n, lights, i, views, one, sizes[one])
        for k in range(0, n, lane_count(rows)):
            if any_lane(load(rows, INSIDE + k) > ZERO):
                filter_light(rows, k, deep, loss)
        for k in range(n):
            work[INSIDE + k] = -work[INSIDE + k] * work[INSIDE + k]  # −1: shaded by an earlier map


@device
def locate(work, n, lights, i, views, one, size):
    """Project the points into map number `one`, `size` texels a side, and store their filter radius for the search.

    Rows: `U`, `V` (texels), `DEPTH` (metres); `INSIDE` is 1 where light arrives and no earlier map contains the point;
    `RADIUS` (texels) is for occluders at the map's centre, or at its front for points in its front half."""
    edge = np.float32(size - 1)
    flat = views[one, PERSPECTIVE] == ZERO
    near = views[one, NEAR_PLANE]
    fine = views[one, FOCAL]
    # perspective maps of one light adjoin each other, so their windows must not extend beyond them
    wide = ONE if flat else ZERO
    for k in range(n):
        u, v, d = project(work[X + k], work[Y + k], work[Z + k], views, one)
        away = max(d - near - HALF * views[one, DEPTH_RANGE], min(d - near, HALF * views[one, DEPTH_RANGE]))
        far = max(d, DARK)
        angle = lights[i, LIGHT_SIZE] if flat or lights[i, KIND] == ZERO else lights[i, LIGHT_SIZE] / far
        blur = angle * fine if flat else angle * fine / far
        wanted = DISC * (blur * away) * (blur * away) - TEXEL
        radius = min(math.sqrt(max(wanted, LEAST * LEAST)), WIDEST)
        room = wide * radius
        held = (d >= near) & (u >= -room) & (v >= -room) & (u < edge + room) & (v < edge + room)
        held = held & (work[INSIDE + k] == ZERO) & (work[ARRIVES + k] > ZERO)
        scale = ONE / fine if flat else ONE / fine * far
        work[U + k] = u if held else ZERO
        work[V + k] = v if held else ZERO
        work[DEPTH + k] = d - lights[i, BIAS]
        work[AWAY + k] = away
        work[BLUR + k] = blur
        work[CLOUD + k] = WIDE * np.float32(size) * scale
        work[RADIUS + k] = radius
        work[INSIDE + k] = ONE if held else work[INSIDE + k]


@device
def filter_light(rows, k, deep, loss):
    """Store what strands leave, in the rows `LEFT`, of the vector of points from number k on that are inside a
    `DeepMap`. rows: `pointer` to the batch; loss: as in `transmittance`."""
    inside = load(rows, INSIDE + k) > ZERO
    u, v, d = load(rows, U + k), load(rows, V + k), load(rows, DEPTH + k)
    cloud = load(rows, CLOUD + k)
    size = np.float32(deep.size)
    radius = blur_radius(rows, k, deep)
    windows, wide, tall = windows_about(u, v, radius, inside, ONE)
    total = ZERO * u
    red = green = blue = total
    for row in range(tall):
        for column in range(wide):
            across, down, weight = texel_of(windows, np.float32(row), np.float32(column), size)
            passed, _, back = in_front(across, down, d, deep)
            total = total + weight
            lost = ONE - exp_lanes(-passed)
            if loss.shape[0] == 0:
                red = red + weight * lost
            else:
                near = weight * cloud / (cloud + max(d - back, ZERO))
                other = (weight - near) * lost
                at = passed / (passed + HALF_WAY) * np.float32(loss.shape[0] - 1)
                j = min(floor(at), np.float32(loss.shape[0] - 2))
                at = at - j
                red = red + near * loss_at(loss, j, at, 0) + other
                green = green + near * loss_at(loss, j, at, 1) + other
                blue = blue + near * loss_at(loss, j, at, 2) + other
    per = ONE / max(total, DARK)
    if loss.shape[0] == 0:
        green = blue = red
    store(rows, LEFT + k, where(inside, ONE - red * per, load(rows, LEFT + k)))
    store(rows, LEFT + W + k, where(inside, ONE - green * per, load(rows, LEFT + W + k)))
    store(rows, LEFT + 2 * W + k, where(inside, ONE - blue * per, load(rows, LEFT + 2 * W + k)))


@inlined
def loss_at(loss, j, part, c):
    """Return the loss of light in colour c between entries j and j + 1 of the table (m, 3). Vectors."""
    table = pointer(loss)
    low = gather(table, c, j, np.int64(3), ZERO)
    return low + part * (gather(table, c + 3, j, np.int64(3), ZERO) - low)


@inlined
def blur_radius(rows, k, deep):
    """Return the filter radius, texels, from the mean distance of the strands that occlude each point of a vector.
    Points without occluders, and those whose radius is already the least, keep that of `RADIUS`."""
    u, v, d = load(rows, U + k), load(rows, V + k), load(rows, DEPTH + k)
    radius, away = load(rows, RADIUS + k), load(rows, AWAY + k)
    searched = radius > LEAST
    used = searched & (load(rows, INSIDE + k) > ZERO)
    windows, wide, tall = windows_about(u, v, radius, used, STEP)
    share = ZERO * u + FEW
    distance = FEW * away
    for row in range(tall):
        for column in range(wide):
            across, down, weight = texel_of(windows, np.float32(row), np.float32(column), np.float32(deep.size))
            passed, front, back = in_front(across, down, d, deep)
            weight = weight * passed / (passed + ONE)
            share = share + weight
            distance = distance + weight * (d - HALF * (front + min(back, d)))
    blur = load(rows, BLUR + k) * (distance / share)
    found = min(sqrt(max(DISC * blur * blur - TEXEL, LEAST * LEAST)), WIDEST)
    return where(searched, found, radius)


@inlined
def in_front(across, down, d, deep):
    """Return, of the texels of a `DeepMap` in the columns `across` (−1: none) and rows `down`: the optical depth in
    front of depths d, and the nearest and farthest depth of the cell's strands, metres; 0 without strands. Vectors."""
    there = across >= ZERO
    column = where(there, across, ZERO)
    row = where(there, down, ZERO)
    left, up = floor(HALF * column), floor(HALF * row)
    half = deep.size >> 1
    body = deep.start + half * half
    number = gather(deep.rows, deep.start, up, half, left)
    layer, part, _, _ = opacity.layers_at(d, deep.rows, body, number, deep.over, deep.layers)
    which = TWO * (row - (up + up)) + (column - (left + left))
    passed = where(there, opacity.depth_at(deep.rows, body, number, layer, part, which, deep.layers), ZERO)
    stride = opacity.HEAD + opacity.FIVE * (deep.layers + 1)
    front = gather(deep.rows, body, number, stride, np.float32(opacity.START))
    ended = gather(deep.rows, body, number, stride, np.float32(opacity.SCALE))
    most = np.float32(deep.layers)
    some = passed > ZERO
    back = where(some, front + most / ((ended - most) * deep.over), ZERO)
    return passed, where(some, front, ZERO), back
