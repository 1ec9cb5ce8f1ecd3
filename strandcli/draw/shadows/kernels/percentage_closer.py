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

import numpy as np

from ....constants import W
from ....jit import device, function, inlined
from ....simd import any_lane, floor, gather4, lane_count, load, pointer, sqrt, store, where
from ...common.kernels.approximations import exp_lanes
from ...common.kernels.batch import ARRIVES, DEPTH, INSIDE, U, V, X, vector_at
from ...common.kernels.light_columns import BIAS, FIRST_MAP, KIND, LIGHT_SIZE, MAP_COUNT, MAP_LAYERS, PER_FALL
from ...common.kernels.numbers import HALF, ONE, TWO, ZERO
from ...common.kernels.surface_batch import AWAY, BLUR, CLOUD, COLUMNS, LEFT, RADIUS
from ...common.kernels.view_columns import DEPTH_RANGE, FOCAL, NEAR_PLANE, PERSPECTIVE
from ...fibre.kernels.dual import HALF_WAY
from . import opacity
from .filter_window import (
    WIDEST,
    DeepMap,
    cell_at,
    cells_in,
    column_of,
    heads_of,
    layers_of,
    passed_at,
    passed_in_cell,
    row_of,
    store_columns,
    windows_about,
)  # fmt: skip
from .minmax import texel_of

ALL, FOUR = np.int64(0), np.int64(4)
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


@function
def transmittance(work, n, lights, i, loss, shadows):
    """Store the transmittance of light number i, in red, green and blue, at the first n points of a batch.

    Reads the rows of positions and `ARRIVES` of `surface_batch`, and writes `LEFT`, which is 1 where no light arrives.
    lights: as in `opacity.optical_depth`; loss (m, 4): from `strandcli.draw.fibre.dual.loss_table`, whose nearest row
    is taken; no rows where strands absorb all colours alike, by 1 − e^-τ; shadows: `ShadowArrays`.
    """
    for k in range(W):
        work[INSIDE + k] = ZERO
    for k in range(3 * W):
        work[LEFT + k] = ONE
    rows = pointer(work)
    for one in range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT])):
        deep = DeepMap(
            pointer(shadows.stacks), np.int64(shadows.starts[one]), np.int64(shadows.sizes[one]),
            np.int64(lights[i, MAP_LAYERS]), lights[i, PER_FALL],
        )  # fmt: skip
        locate(work, n, lights, i, shadows.views, one, shadows.sizes[one])
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
        u, v, d = texel_of(vector_at(work, X, k), views, one)
        away = max(d - near - HALF * views[one, DEPTH_RANGE], min(d - near, HALF * views[one, DEPTH_RANGE]))
        far = max(d, DARK)
        angle = lights[i, LIGHT_SIZE] if flat or lights[i, KIND] == ZERO else lights[i, LIGHT_SIZE] / far
        blur = angle * fine if flat else angle * fine / far
        wanted = DISC * (blur * away) * (blur * away) - TEXEL
        radius = min(math.sqrt(max(wanted, LEAST * LEAST)), WIDEST)
        room = wide * radius
        within = (d >= near) & (u >= -room) & (v >= -room) & (u < edge + room) & (v < edge + room)
        within = within & (work[INSIDE + k] == ZERO) & (work[ARRIVES + k] > ZERO)
        scale = ONE / fine if flat else ONE / fine * far
        work[U + k] = u if within else ZERO
        work[V + k] = v if within else ZERO
        work[DEPTH + k] = d - lights[i, BIAS]
        work[AWAY + k] = away
        work[BLUR + k] = blur
        work[CLOUD + k] = WIDE * np.float32(size) * scale
        work[RADIUS + k] = radius
        work[INSIDE + k] = ONE if within else work[INSIDE + k]


@device
def filter_light(rows, k, deep, loss):
    """Store what strands leave, in the rows `LEFT`, of the vector of points from number k on that are inside a
    `DeepMap`. rows: `pointer` to the batch; loss: as in `transmittance`."""
    inside = load(rows, INSIDE + k) > ZERO
    u, v, d = places_of(rows, k, inside)
    cloud = load(rows, CLOUD + k)
    radius = blur_radius(rows, k, deep)
    windows, wide, tall = windows_about(u, v, radius, inside, ONE)
    texels = opacity.TEXELS if any_lane(windows.stride < TWO) else 1
    lanes = lane_count(rows)
    sums = store_columns(windows, wide, rows, np.int64(COLUMNS))
    tall_sum = red = green = blue = ZERO * u
    for row in range(tall):
        down, above, below = row_of(windows, np.float32(row))
        tall_sum = tall_sum + (above + below)
        for column in range(wide):
            across = column_of(windows, np.float32(column))
            there = cells_in(across, down, inside, deep)
            front, scale, blocks_light = heads_of(across, down, there, d, deep)
            if not blocks_light:
                continue
            left = load(rows, COLUMNS + 2 * column * lanes)
            right = load(rows, COLUMNS + (2 * column + 1) * lanes)
            number = cell_at(across, down, there, deep)
            layer, part, back = layers_of(front, scale, d, deep)
            lost = ZERO * u, ZERO * u, ZERO * u, ZERO * u
            if texels == 1:
                lost = lost_in(lost, left * above, passed_at(number, layer, part, deep), loss)
            else:
                one, two, three, four = passed_in_cell(number, layer, part, deep)
                lost = lost_in(lost, left * above, one, loss)
                lost = lost_in(lost, right * above, two, loss)
                lost = lost_in(lost, left * below, three, loss)
                lost = lost_in(lost, right * below, four, loss)
            grey, lost_r, lost_g, lost_b = lost
            if loss.shape[0] == 0:
                red = red + grey
            else:
                near = cloud / (cloud + max(d - back, ZERO))
                red = red + (near * lost_r + (grey - near * grey))
                green = green + (near * lost_g + (grey - near * grey))
                blue = blue + (near * lost_b + (grey - near * grey))
    per = ONE / max((sums[0] + sums[1]) * tall_sum, DARK)
    if loss.shape[0] == 0:
        green = blue = red
    store(rows, LEFT + k, where(inside, ONE - red * per, load(rows, LEFT + k)))
    store(rows, LEFT + W + k, where(inside, ONE - green * per, load(rows, LEFT + W + k)))
    store(rows, LEFT + 2 * W + k, where(inside, ONE - blue * per, load(rows, LEFT + 2 * W + k)))


@inlined
def lost_in(lost, weight, passed, loss):
    """Return what strands keep of light, grey and in red, green and blue, with that of a texel of an optical depth
    added. Vectors; loss: as in `transmittance`."""
    grey, red, green, blue = lost
    grey = grey + weight * (ONE - exp_lanes(-passed))
    if loss.shape[0] > 0:
        at = floor(passed / (passed + HALF_WAY) * np.float32(loss.shape[0] - 1) + HALF)
        r, g, b, _ = gather4(pointer(loss), ALL, at, FOUR, ZERO)
        red = red + weight * r
        green = green + weight * g
        blue = blue + weight * b
    return grey, red, green, blue


@inlined
def blur_radius(rows, k, deep):
    """Return the filter radius, texels, from the mean distance of the strands that occlude each point of a vector.
    Points without occluders, and those whose radius is already the least, keep that of `RADIUS`."""
    inside = load(rows, INSIDE + k) > ZERO
    u, v, d = places_of(rows, k, inside)
    radius, away = where(inside, load(rows, RADIUS + k), LEAST), load(rows, AWAY + k)
    used = radius > LEAST
    windows, wide, tall = windows_about(u, v, radius, used, STEP)
    lanes = lane_count(rows)
    store_columns(windows, wide, rows, np.int64(COLUMNS))
    share = ZERO * u + FEW
    distance = FEW * away
    for row in range(tall):
        down, above, _ = row_of(windows, np.float32(row))
        for column in range(wide):
            across = column_of(windows, np.float32(column))
            there = cells_in(across, down, used, deep)
            front, scale, blocks_light = heads_of(across, down, there, d, deep)
            if not blocks_light:
                continue
            left = load(rows, COLUMNS + 2 * column * lanes)
            number = cell_at(across, down, there, deep)
            layer, part, back = layers_of(front, scale, d, deep)
            passed = passed_at(number, layer, part, deep)
            weight = left * above * passed / (passed + ONE)
            share = share + weight
            distance = distance + weight * (d - HALF * (front + min(back, d)))
    blur = load(rows, BLUR + k) * (distance / share)
    found = min(sqrt(max(DISC * blur * blur - TEXEL, LEAST * LEAST)), WIDEST)
    return where(used, found, radius)


@inlined
def places_of(rows, k, inside):
    """Return column and row, texels, and depth, metres, of the points from number k on; 0 where not inside. Vectors."""
    u, v, d = load(rows, U + k), load(rows, V + k), load(rows, DEPTH + k)
    return where(inside, u, ZERO), where(inside, v, ZERO), where(inside, d, ZERO)
