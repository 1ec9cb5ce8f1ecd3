"""Shadows of strands on solids, from deep opacity maps.

On strands the steps between texels do not show; on smooth skin each texel shows as a square. So what is left of the
light is averaged over the texels about a point (percentage-closer filtering, Reeves, Salesin & Cook 1987), by weights
that fall smoothly to zero at R texels, (1 − (x / R)²)² along each side. R is a texel and a half at the least, where the
weights are close to a quadratic spline, and more where the light has a size: the shadow of strands at a distance D is
blurred by a disc of the light's angular radius times D, of which a texel itself is a part. D is the mean distance of
the strands that hide the light, by how much each texel hides, over every other texel as far as strands in the map's
middle would blur, or at its front for points before that (Fernando 2005): what touches the skin is blurred little,
however far away the rest of the groom is. Where R is large only some texels are read (`filter_window`).

Light that strands scatter leaves in all directions and arrives beside their shadow, the more so the further behind
them a point is. Of what a disc scatters, a share of about w / (w + g) falls on a disc of its size at a distance g, w
being .6 of its radius (their view factor). What is translucent of a groom is its fringe: w is taken as a sixteenth of
the map's width. Without this a coat's shadow would have a warm rim far from it, and not on the skin under it alone.

On a ground under a thousand strands the mean error against rays to all of a light is .023 where it is blurred by three
texels, .037 without the filter; where by one and less, .038 with it and .033 without.
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
"""Texels to each side over which a light is averaged at the least."""
DISC = np.float32(7.0 / 4.0)
TEXEL = np.float32(7.0 / 12.0)
"""R² of weights, whose variance is R² / 7, for that of a disc of radius one, a quarter, and of a texel, a twelfth."""
DARK = np.float32(1e-6)
FEW = np.float32(1e-3)
"""Weight of strands that hide next to nothing."""
STEP = 2
"""Texels from one whose strands' distance is read to the next."""
WIDE = np.float32(1 / 16)
"""The w of scattered light, of a map's width."""


@function
def transmittance(work, n, lights, i, loss, stacks, starts, sizes, views):
    """Store the share of light number i, in red, green and blue, that strands leave the first n points of a batch.

    Rows of `surface_batch`: from the points' places and `ARRIVES` to `LEFT`, which is 1 where nothing arrives.
    lights … views: as of `opacity.optical_depth`; loss (m, 3): of `strandcli.draw.fibre.dual.loss_table`, no rows where
    strands shade in grey, by e^-τ.
    """
    # The loop over texels is the outer one: a texel is the same place in the windows of all points, and weighs nothing
    # where it is beyond a point's window.
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
            work[INSIDE + k] = -work[INSIDE + k] * work[INSIDE + k]  # −1: by a map before


@device
def locate(work, n, lights, i, views, one, size):
    """Store where map number `one`, `size` texels a side, shows each point: rows `U`, `V` in texels, `DEPTH` in metres;
    1 in the row `INSIDE` where light arrives and no map before held the point; and in `RADIUS` the blur, texels, of
    strands in the map's middle, or at its front for points in its front half."""
    edge = np.float32(size - 1)
    flat = views[one, PERSPECTIVE] == ZERO
    near = views[one, NEAR_PLANE]
    fine = views[one, FOCAL]
    # beside a perspective map begins the next one of the same light
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
    """Texels to each side over which a light is averaged that strands blur by a disc of that radius, texels."""
    return min(math.sqrt(max(DISC * blur * blur - TEXEL, LEAST * LEAST)), WIDEST)


@device
def find_blur(work, n, size, start, over, layers, stacks):
    """Set the rows `RADIUS`, texels, by the mean distance of the strands that hide the light from each point; rows of
    points that no strand hides, or whose radius is the least already, stay.

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
    """Store the optical depth in front of each point at the texel of rows `ACROSS`, `DOWN`, 0 where there is none, and
    where the strands of its cell begin and end, metres: rows `PASSED`, `FRONT`, `BACK`."""
    rows, maps = pointer(work), pointer(stacks)
    half = size >> 1
    body = start + half * half
    most = np.float32(layers)
    stride = opacity.HEAD + opacity.FIVE * (layers + 1)
    for k in range(n, W):  # the last vector's other lanes read something too
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
        passed = where(there, opacity.within(maps, body, number, layer, part, which, layers), ZERO)
        front = gather(maps, body, number, stride, ZERO)
        ended = gather(maps, body, number, stride, ONE)
        some = passed > ZERO
        store(rows, PASSED + k, passed)
        store(rows, FRONT + k, where(some, front, ZERO))
        store(rows, BACK + k, where(some, front + most / ((ended - most) * over), ZERO))


@device
def add_loss(work, n, loss):
    """Add to the rows `LOST` the light that strands at that texel take from each point, in red, green and blue; loss:
    as of `transmittance`."""
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
