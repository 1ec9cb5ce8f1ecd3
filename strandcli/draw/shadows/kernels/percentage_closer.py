"""Shadows of strands on solids, from deep opacity maps.

On strands a texel's steps drown among strands; on smooth skin each shows as a square. So here what is left of the light
is averaged over the texels about a point (percentage-closer filtering, Reeves, Salesin & Cook 1987), by weights that
fall smoothly to nothing at R texels, (1 − (x / R)²)² along each side. R is a texel and a half at the least, where they
are next to a quadratic spline, and more where the light has a size: the shadow of strands at a distance D is blurred by
a disc of the light's angular radius times D, of which a texel itself is a part. D is the mean distance of the strands
that hide the light, by how much each texel hides, over every other texel as far as strands in the map's middle would
blur, or at its front for points before that (Fernando 2005): what touches the skin is blurred little, however far away
the rest of the groom is.
Where R is more than six texels only every second one is looked at, every fourth at more than twelve, and so on to
every sixteenth at more than 48, which costs no more than six do; the others fade out before, so that no step shows
where they go.

Light that strands scatter on goes all ways and comes down beside their shadow, the more so the further behind them a
point is. Of what a disc sends on, a share of about w / (w + g) falls on a disc of its size at a distance g, w being .6
of its radius (their view factor). What is translucent of a groom is its fringe: w is taken as a sixteenth of the
map's width. Without this a coat's shadow would have a warm rim far from it, and not on the skin under it alone.

On a ground under a thousand strands the mean error against rays to all of a light is .023 where it is blurred by three
texels, .037 without the filter; where by one and less, .038 against .033: smoothness has its price.
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
    FADE,
    FIRST_U,
    FIRST_V,
    FRONT,
    LAST_U,
    LAST_V,
    LEFT,
    LOST,
    NEAR,
    OTHER,
    PASSED,
    PER,
    RADIUS,
    STRIDE,
    TOTAL,
    WEIGHT,
)
from ...common.kernels.view_columns import DEPTH_RANGE, FOCAL, NEAR_PLANE, PERSPECTIVE
from . import opacity
from .minmax import texel_of

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
FOUR = np.float32(4.0)
EIGHT = np.float32(8.0)
SIXTEEN = np.float32(16.0)
LEAST = np.float32(1.5)
MOST = np.float32(6.0)
"""Texels to each side that are looked at."""
WIDEST = SIXTEEN * MOST
"""And over which a light is averaged at the most."""
FADED = np.float32(0.75)
"""Of MOST, from where on every other texel fades out."""
DISC = np.float32(7.0 / 4.0)
TEXEL = np.float32(7.0 / 12.0)
"""R² of weights, whose variance is R² / 7, for that of a disc of radius one, a quarter, and of a texel, a twelfth."""
DARK = np.float32(1e-6)
FEW = np.float32(1e-3)
"""Weight of strands that hide next to nothing."""
STEP = 2
"""Texels from one that is asked for its strands' distance to the next."""
WIDE = np.float32(1 / 16)
"""Of a map's width, the w of light that goes on."""


@function
def leave(work, n, lights, i, veil, stacks, starts, sizes, views):
    """Share of light number i, in red, green and blue, that strands leave the first n points of a batch on a solid.

    Rows of `surface_batch`: from the points and what `ARRIVES`, to `LEFT`, which is 1 where nothing arrives. lights …
    views: as `opacity.optical_depth`; lights [12]: the light's size,
    of `strandcli.draw.lighting.pack_lights.pack_lights`; veil
    (n, 3): of `strandcli.draw.fibre.dual.loss_table`, none where strands shade in grey and by e^-τ alone.

    Texel by texel, each of which is the same place about all points: those that a point has none at weigh nothing.
    """
    for k in range(n):
        work[INSIDE + k] = ZERO
    for k in range(3 * W):
        work[LEFT + k] = ONE
    layers = np.int64(lights[i, MAP_LAYERS])
    for one in range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT])):
        size = sizes[one]
        start = starts[one]
        hold(work, n, lights, i, views, one, size)
        search(work, n, np.float32(size), start, lights[i, PER_FALL], layers, stacks)
        wide, tall = about(work, n, ONE, ZERO)
        for k in range(n):
            work[TOTAL + k] = ZERO
        for k in range(3 * W):
            work[LOST + k] = ZERO
        for row in range(tall):
            for column in range(wide):
                weigh(work, n, np.float32(row), np.float32(column), np.float32(size))
                sink(work, n, start, size, lights[i, PER_FALL], layers, stacks)
                if veil.shape[0] == 0:
                    for k in range(n):
                        passed = work[PASSED + k]
                        lost = work[WEIGHT + k] * (ONE - exp(-passed))
                        work[LOST + k] += lost if passed > ZERO else ZERO
                else:
                    dim(work, n, veil)
        for c in range(3):
            row = LOST if veil.shape[0] == 0 else LOST + c * W
            for k in range(n):
                left = ONE - work[row + k] * (ONE / max(work[TOTAL + k], DARK))
                work[LEFT + c * W + k] = left if work[INSIDE + k] > ZERO else work[LEFT + c * W + k]
        for k in range(n):
            work[INSIDE + k] = -work[INSIDE + k] * work[INSIDE + k]  # −1: by a map before


@device
def hold(work, n, lights, i, views, one, size):
    """Where each point is in a map, 1 in the row `INSIDE` where light arrives at it and no map before held it, and how
    far strands would blur that are in the map's middle, or at its front for points in its front half."""
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
        radius = reach(blur * away)
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
def reach(blur):
    """Texels to each side over which a disc of so many texels is averaged."""
    return min(math.sqrt(max(DISC * blur * blur - TEXEL, LEAST * LEAST)), WIDEST)


@device
def search(work, n, size, start, over, layers, stacks):
    """How far the strands blur that hide the light: by their mean distance from each point, as far as there are any."""
    wide, tall = about(work, n, np.float32(STEP), LEAST)
    if wide == 0:
        return
    for k in range(n):
        work[LOST + k] = FEW
        work[LOST + W + k] = FEW * work[AWAY + k]
    for row in range(tall):
        for column in range(wide):
            weigh(work, n, np.float32(row), np.float32(column), size)
            sink(work, n, start, np.int64(size), over, layers, stacks)
            for k in range(n):
                passed = work[PASSED + k]
                d = work[DEPTH + k]
                weight = work[WEIGHT + k] * passed / (passed + ONE) if passed > ZERO else ZERO
                work[LOST + k] += weight
                work[LOST + W + k] += weight * (d - HALF * (work[FRONT + k] + min(work[BACK + k], d)))
    for k in range(n):
        found = reach(work[BLUR + k] * (work[LOST + W + k] / work[LOST + k]))
        work[RADIUS + k] = found if work[RADIUS + k] > LEAST else work[RADIUS + k]


@device
def about(work, n, step, least):
    """Which texels are about each point that this map holds and that is averaged over more than `least`, from the first
    that `step`, or more where many are about it, divides; returns the greatest number of columns and of rows."""
    for k in range(n):
        radius = work[RADIUS + k]
        u = work[U + k]
        v = work[V + k]
        asked = (work[INSIDE + k] > ZERO) & (radius > least)
        times = ONE if radius <= MOST else TWO if radius <= TWO * MOST else FOUR
        times = times if radius <= FOUR * MOST else EIGHT if radius <= EIGHT * MOST else SIXTEEN
        stride = step * times
        share = ONE / stride
        left = -stride * below((radius - u) * share)
        top = -stride * below((radius - v) * share)
        work[PER + k] = ONE / radius
        work[STRIDE + k] = stride
        work[FADE + k] = max((radius / (times * MOST) - FADED) * (ONE / (ONE - FADED)), ZERO)
        work[FIRST_U + k] = left
        work[FIRST_V + k] = top
        work[LAST_U + k] = below(u + radius) if asked else left - stride
        work[LAST_V + k] = below(v + radius) if asked else top - stride
    return most(work, n, FIRST_U, LAST_U), most(work, n, FIRST_V, LAST_V)


@device
def below(x):
    """The greatest whole number that is no greater, as a loop's compiler knows it."""
    whole = np.float32(np.int32(x))
    return whole - ONE if whole > x else whole


@device
def most(work, n, first, last):
    """The greatest number of columns or rows that a point has about it."""
    out = ZERO
    for k in range(n):
        out = max(out, (work[last + k] - work[first + k]) / work[STRIDE + k] + ONE)
    return np.int64(out)


@device
def weigh(work, n, row, column, size):
    """Place and weight of the texel in this row and column of those about each point."""
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
    """1 where a whole number, of which this is half, is odd, and 0 where it is even."""
    return TWO * (half - below(half))


@device
def sink(work, n, start, size, over, layers, stacks):
    """Strands in front of each point in that texel, 0 where there is none, and the depths where those of its cell begin
    and end."""
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
def dim(work, n, veil):
    """Add the light that strands in that texel take from each point, in red, green and blue."""
    for k in range(n):
        cloud = work[CLOUD + k]
        gap = max(work[DEPTH + k] - work[BACK + k], ZERO)
        near = work[WEIGHT + k] * cloud / (cloud + gap)
        work[NEAR + k] = near
        work[OTHER + k] = (work[WEIGHT + k] - near) * (ONE - exp(-work[PASSED + k]))
    for k in range(n):
        passed = work[PASSED + k]
        if passed > ZERO:
            at = passed / (passed + HALF_WAY) * np.float32(veil.shape[0] - 1)
            j = min(np.int64(at), veil.shape[0] - 2)
            at -= np.float32(j)
            for c in range(3):
                work[LOST + c * W + k] += (
                    work[NEAR + k] * (veil[j, c] + at * (veil[j + 1, c] - veil[j, c])) + work[OTHER + k]
                )
