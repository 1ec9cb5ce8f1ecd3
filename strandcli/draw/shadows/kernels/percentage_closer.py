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
from ....simd import floor, gather, lane_count, load, pointer, sqrt, store, store3, where
from ...common.kernels.approximations import exp_lanes
from ...common.kernels.batch import ARRIVES, DEPTH, INSIDE, U, V, X, Y, Z
from ...common.kernels.light_columns import BIAS, FIRST_MAP, KIND, LIGHT_SIZE, MAP_COUNT, MAP_LAYERS, PER_FALL
from ...common.kernels.loss import HALF_WAY
from ...common.kernels.surface_batch import AWAY, BLUR, CLOUD, FILTERED, FOUND, LEFT, LIST, RADIUS
from ...common.kernels.view_columns import DEPTH_RANGE, FOCAL, NEAR_PLANE, PERSPECTIVE
from . import opacity, sparse_filter
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
FAR = np.float32(1e30)
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
        count = sparse_filter.list_ends(work, n, texel_side(work, n, sizes[one]))
        while count > 0:
            for k in range(count, -(-count // lane_count(rows)) * lane_count(rows)):
                work[LIST + k] = work[LIST + count - 1]
            for k in range(0, count, lane_count(rows)):
                filter_light(rows, k, deep, loss)
            sparse_filter.scatter(work, count)
            count = sparse_filter.list_between(work, n)
        sparse_filter.interpolate(work, n)
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
def texel_side(work, n, size):
    """Return the least side of a texel at the points of a batch that are inside, metres; size: texels a side."""
    cloud = FAR
    for k in range(n):
        cloud = min(cloud, work[CLOUD + k] if work[INSIDE + k] > ZERO else FAR)
    return cloud / (WIDE * np.float32(size))


@device
def filter_light(rows, k, deep, loss):
    """Store what strands leave, in the rows `FILTERED`, of a vector of points inside a `DeepMap`, whose numbers stand
    in the row `LIST` from place k on, and in `FOUND` the filter radius. rows: `pointer` to the batch; loss: as in
    `transmittance`."""
    at = load(rows, LIST + k)
    u, v, d = of_points(rows, U, at), of_points(rows, V, at), of_points(rows, DEPTH, at)
    cloud = of_points(rows, CLOUD, at)
    size = np.float32(deep.size)
    radius = blur_radius(rows, at, deep)
    store(rows, FOUND + k, radius)
    windows, wide, tall = windows_about(u, v, radius, at >= ZERO, ONE)
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
                place = passed / (passed + HALF_WAY) * np.float32(loss.shape[0] - 1)
                j = min(floor(place), np.float32(loss.shape[0] - 2))
                part = place - j
                red = red + near * loss_at(loss, j, part, 0) + other
                green = green + near * loss_at(loss, j, part, 1) + other
                blue = blue + near * loss_at(loss, j, part, 2) + other
    per = ONE / max(total, DARK)
    if loss.shape[0] == 0:
        green = blue = red
    store3(rows, FILTERED + k, W, ONE - red * per, ONE - green * per, ONE - blue * per)


@inlined
def of_points(rows, row, at):
    """Return a vector of the numbers of a row at the places ``at``."""
    return gather(rows, np.int64(row), at, np.int64(1), ZERO)


@inlined
def loss_at(loss, j, part, c):
    """Return the loss of light in colour c between entries j and j + 1 of the table (m, 3). Vectors."""
    table = pointer(loss)
    low = gather(table, c, j, np.int64(3), ZERO)
    return low + part * (gather(table, c + 3, j, np.int64(3), ZERO) - low)


@inlined
def blur_radius(rows, at, deep):
    """Return the filter radius, texels, from the mean distance of the strands that occlude each point of a vector.
    Points without occluders, and those whose radius is already the least, keep that of `RADIUS`."""
    u, v, d = of_points(rows, U, at), of_points(rows, V, at), of_points(rows, DEPTH, at)
    radius, away = of_points(rows, RADIUS, at), of_points(rows, AWAY, at)
    searched = radius > LEAST
    windows, wide, tall = windows_about(u, v, radius, searched, STEP)
    share = ZERO * u + FEW
    distance = FEW * away
    for row in range(tall):
        for column in range(wide):
            across, down, weight = texel_of(windows, np.float32(row), np.float32(column), np.float32(deep.size))
            passed, front, back = in_front(across, down, d, deep)
            weight = weight * passed / (passed + ONE)
            share = share + weight
            distance = distance + weight * (d - HALF * (front + min(back, d)))
    blur = of_points(rows, BLUR, at) * (distance / share)
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
