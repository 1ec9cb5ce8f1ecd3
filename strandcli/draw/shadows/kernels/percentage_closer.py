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
from ....jit import device, function
from ....simd import floor, gather, lane_count, load, pointer, store, where
from ...common.kernels.approximations import exp
from ...common.kernels.batch import ARRIVES, DEPTH, INSIDE, U, V, X, Y, Z
from ...common.kernels.light_columns import BIAS, FIRST_MAP, KIND, LIGHT_SIZE, MAP_COUNT, MAP_LAYERS, PER_FALL
from ...common.kernels.loss import HALF_WAY
from ...common.kernels.surface_batch import (
    ACROSS,
    AWAY,
    BACK,
    BLUR,
    CLOUD,
    DOWN,
    FRONT,
    LEFT,
    LOST,
    NEAR,
    OTHER,
    PASSED,
    RADIUS,
    TOTAL,
    WEIGHT,
)
from ...common.kernels.view_columns import DEPTH_RANGE, FOCAL, NEAR_PLANE, PERSPECTIVE
from . import opacity
from .filter_window import WIDEST, place_texel, place_windows
from .minmax import texel_of

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
STEP = 2
"""Distance, in texels, between the texels that the occluder search reads."""
WIDE = np.float32(1 / 16)
"""w of scattered light, as a share of a map's width."""


@function
def transmittance(work, n, lights, i, loss, stacks, starts, sizes, views):
    """Store the transmittance of light number i, in red, green and blue, at the first n points of a batch.

    Reads the rows of positions and `ARRIVES` of `surface_batch`, and writes `LEFT`, which is 1 where no light arrives.
    lights, stacks, starts, sizes, views: as in `opacity.optical_depth`; loss (m, 3): from
    `strandcli.draw.fibre.dual.loss_table`, no rows where strands absorb all colours alike, by 1 − e^-τ.
    """
    # The loop over texels is the outer one: every point uses the texel at the same offset in its window, with weight 0
    # where its window is smaller.
    for k in range(n):
        work[INSIDE + k] = ZERO
    for k in range(3 * W):
        work[LEFT + k] = ONE
    layers = np.int64(lights[i, MAP_LAYERS])
    for one in range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT])):
        size = sizes[one]
        start = starts[one]
        locate(work, n, lights, i, views, one, size)
        find_blur(work, n, np.float32(size), start, lights[i, PER_FALL], layers, stacks)
        wide, tall = place_windows(work, n, ONE, ZERO)
        for k in range(n):
            work[TOTAL + k] = ZERO
        for k in range(3 * W):
            work[LOST + k] = ZERO
        for row in range(tall):
            for column in range(wide):
                place_texel(work, n, np.float32(row), np.float32(column), np.float32(size))
                count_in_front(work, n, start, size, lights[i, PER_FALL], layers, stacks)
                if loss.shape[0] == 0:
                    for k in range(n):
                        passed = work[PASSED + k]
                        dimmed = work[WEIGHT + k] * (ONE - exp(-passed))
                        work[LOST + k] += dimmed if passed > ZERO else ZERO
                else:
                    add_loss(work, n, loss)
        for c in range(3):
            row = LOST if loss.shape[0] == 0 else LOST + c * W
            for k in range(n):
                left = ONE - work[row + k] * (ONE / max(work[TOTAL + k], DARK))
                work[LEFT + c * W + k] = left if work[INSIDE + k] > ZERO else work[LEFT + c * W + k]
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
        u, v, d = texel_of(work[X + k], work[Y + k], work[Z + k], views, one)
        away = max(d - near - HALF * views[one, DEPTH_RANGE], min(d - near, HALF * views[one, DEPTH_RANGE]))
        far = max(d, DARK)
        angle = lights[i, LIGHT_SIZE] if flat or lights[i, KIND] == ZERO else lights[i, LIGHT_SIZE] / far
        blur = angle * fine if flat else angle * fine / far
        radius = radius_for(blur * away)
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
def radius_for(blur):
    """Return the filter radius, texels, for a blur by a disc of radius `blur`, texels."""
    return min(math.sqrt(max(DISC * blur * blur - TEXEL, LEAST * LEAST)), WIDEST)


@device
def find_blur(work, n, size, start, over, layers, stacks):
    """Set the rows `RADIUS`, texels, from the mean distance of the strands that occlude each point. Points without
    occluders, and those whose radius is already the least, keep theirs.

    size: texels a side, float32; start, over, layers, stacks: as of `opacity.in_front`.
    """
    wide, tall = place_windows(work, n, np.float32(STEP), LEAST)
    if wide == 0:
        return
    for k in range(n):
        work[LOST + k] = FEW
        work[LOST + W + k] = FEW * work[AWAY + k]
    for row in range(tall):
        for column in range(wide):
            place_texel(work, n, np.float32(row), np.float32(column), size)
            count_in_front(work, n, start, np.int64(size), over, layers, stacks)
            for k in range(n):
                passed = work[PASSED + k]
                d = work[DEPTH + k]
                weight = work[WEIGHT + k] * passed / (passed + ONE) if passed > ZERO else ZERO
                work[LOST + k] += weight
                work[LOST + W + k] += weight * (d - HALF * (work[FRONT + k] + min(work[BACK + k], d)))
    for k in range(n):
        found = radius_for(work[BLUR + k] * (work[LOST + W + k] / work[LOST + k]))
        work[RADIUS + k] = found if work[RADIUS + k] > LEAST else work[RADIUS + k]


@device
def count_in_front(work, n, start, size, over, layers, stacks):
    """Store for each point, at the texel of the rows `ACROSS`, `DOWN`: the optical depth in front of it (`PASSED`, 0
    without a texel), and the nearest and farthest depth of the cell's strands, metres (`FRONT`, `BACK`)."""
    rows, maps = pointer(work), pointer(stacks)
    half = size >> 1
    body = start + half * half
    most = np.float32(layers)
    stride = opacity.HEAD + opacity.FIVE * (layers + 1)
    for k in range(n, W):  # the unused lanes of the last vector must read valid texels
        work[ACROSS + k] = -ONE
    for k in range(0, n, lane_count(rows)):
        across = load(rows, ACROSS + k)
        there = across >= ZERO
        column = where(there, across, ZERO)
        row = where(there, load(rows, DOWN + k), ZERO)
        left, up = floor(HALF * column), floor(HALF * row)
        number = gather(maps, start, up, half, left)
        layer, part, _, _ = opacity.layers_at(load(rows, DEPTH + k), maps, body, number, over, layers)
        which = TWO * (row - (up + up)) + (column - (left + left))
        passed = where(there, opacity.depth_at(maps, body, number, layer, part, which, layers), ZERO)
        front = gather(maps, body, number, stride, ZERO)
        ended = gather(maps, body, number, stride, ONE)
        some = passed > ZERO
        store(rows, PASSED + k, passed)
        store(rows, FRONT + k, where(some, front, ZERO))
        store(rows, BACK + k, where(some, front + most / ((ended - most) * over), ZERO))


@device
def add_loss(work, n, loss):
    """Add the weighted loss of light at the current texel, in red, green and blue, to the rows `LOST`; loss: as in
    `transmittance`."""
    for k in range(n):
        cloud = work[CLOUD + k]
        gap = max(work[DEPTH + k] - work[BACK + k], ZERO)
        near = work[WEIGHT + k] * cloud / (cloud + gap)
        work[NEAR + k] = near
        work[OTHER + k] = (work[WEIGHT + k] - near) * (ONE - exp(-work[PASSED + k]))
    for k in range(n):
        passed = work[PASSED + k]
        if passed > ZERO:
            at = passed / (passed + HALF_WAY) * np.float32(loss.shape[0] - 1)
            j = min(np.int64(at), loss.shape[0] - 2)
            at -= np.float32(j)
            for c in range(3):
                work[LOST + c * W + k] += (
                    work[NEAR + k] * (loss[j, c] + at * (loss[j + 1, c] - loss[j, c])) + work[OTHER + k]
                )
