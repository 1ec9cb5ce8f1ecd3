"""Shadows of strands on solids, from deep opacity maps.

On strands a texel's steps drown among strands; on smooth skin each shows as a square. So here what is left of the light
is averaged over the texels about a point (percentage-closer filtering, Reeves, Salesin & Cook 1987), by weights that
fall smoothly to nothing at R texels, (1 − (x / R)²)² along each side. R is a texel and a half at the least, where they
are next to a quadratic spline, and more where the light has a size: the shadow of strands at a distance D is blurred by
a disc of the light's angular radius times D, of which a texel itself is a part. Strands are taken to be in the middle
of the map's depths, which needs no search: what touches the skin is blurred too much where the rest of the groom is far
away.

On a ground under a thousand strands the mean error against rays to all of a light is .018 where it is blurred by three
texels, .036 without the filter; where by one, .033 against .023: smoothness has its price.
"""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import function, inner
from . import opacity
from .approximations import exp
from .batch import ARRIVES, DEPTH, INSIDE, U, V, X, Y, Z
from .dual import HALF_WAY
from .shadow import texel_of
from .surface_batch import FIRST_U, FIRST_V, LAST_U, LAST_V, LEFT, LOST, PASSED, PER, PLACE, TOTAL, WEIGHT

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
LEAST = np.float32(1.5)
MOST = np.float32(6.0)
"""Texels to each side."""
DISC = np.float32(7.0 / 4.0)
TEXEL = np.float32(7.0 / 12.0)
"""R² of weights, whose variance is R² / 7, for that of a disc of radius one, a quarter, and of a texel, a twelfth."""
DARK = np.float32(1e-6)


@function
def leave(work, n, lights, i, veil, stacks, starts, sizes, views):
    """Share of light number i, in red, green and blue, that strands leave the first n points of a batch on a solid.

    Rows of `surface_batch`: from the points and what `ARRIVES`, to `LEFT`, which is 1 where nothing arrives. lights …
    views: as `opacity.optical_depth`; lights [12]: the light's size, of `strandcli.draw.shading.pack_lights`; veil
    (n, 3): of `strandcli.draw.dual.veil_of`, None where strands shade in grey and by e^-τ alone.

    Texel by texel, each of which is the same place about all points: those that a point has none at weigh nothing.
    """
    for k in range(n):
        work[INSIDE + k] = ZERO
    for k in range(3 * W):
        work[LEFT + k] = ONE
    for one in range(int(lights[i, 7]), int(lights[i, 7] + lights[i, 8])):
        size = sizes[one]
        about(work, n, lights, i, views, one, size)
        wide = most(work, n, FIRST_U, LAST_U)
        tall = most(work, n, FIRST_V, LAST_V)
        for k in range(n):
            work[TOTAL + k] = ZERO
        for k in range(3 * W):
            work[LOST + k] = ZERO
        for row in range(tall):
            for column in range(wide):
                weigh(work, n, np.float32(row), np.float32(column), np.float32(size))
                sink(work, n, np.uint64(starts[one]), np.int64(lights[i, 10]), stacks)
                if veil is None:
                    for k in range(n):
                        passed = work[PASSED + k]
                        lost = work[WEIGHT + k] * (ONE - exp(-passed))
                        work[LOST + k] += lost if passed > ZERO else ZERO
                else:
                    dim(work, n, veil)
        for c in range(3):
            row = LOST if veil is None else LOST + c * W
            for k in range(n):
                left = ONE - work[row + k] * (ONE / max(work[TOTAL + k], DARK))
                work[LEFT + c * W + k] = left if work[INSIDE + k] > ZERO else work[LEFT + c * W + k]
        for k in range(n):
            work[INSIDE + k] = -work[INSIDE + k] * work[INSIDE + k]  # −1: by a map before


@inner
def about(work, n, lights, i, views, one, size):
    """Which texels of a map are about each point that light arrives at and that no map before held; 1 in the row
    `INSIDE` where there are any."""
    edge = np.float32(size - 1)
    flat = views[one, 12] == ZERO
    near = views[one, 14]
    # beside a perspective map begins the next one of the same light
    room = MOST if flat else ZERO
    for k in range(n):
        u, v, d = texel_of(work[X + k], work[Y + k], work[Z + k], views, one)
        held = (d >= near) & (u >= -room) & (v >= -room) & (u < edge + room) & (v < edge + room)
        held = held & (work[INSIDE + k] == ZERO) & (work[ARRIVES + k] > ZERO)
        u = u if held else ZERO
        v = v if held else ZERO
        away = max(d - near - HALF * views[one, 19], ZERO)
        far = max(d, DARK)
        angle = lights[i, 12] if flat or lights[i, 0] == ZERO else lights[i, 12] / far
        blur = angle * away * views[one, 13]
        blur = blur if flat else blur / far
        reach = min(math.sqrt(max(DISC * blur * blur - TEXEL, LEAST * LEAST)), MOST)
        work[U + k] = u
        work[V + k] = v
        work[DEPTH + k] = d - lights[i, 9]
        work[PER + k] = ONE / reach
        work[FIRST_U + k] = -below(reach - u)
        work[FIRST_V + k] = -below(reach - v)
        work[LAST_U + k] = below(u + reach) if held else -MOST - MOST
        work[LAST_V + k] = below(v + reach) if held else -MOST - MOST
        work[INSIDE + k] = ONE if held else work[INSIDE + k]


@inner
def below(x):
    """The greatest whole number that is no greater, as a loop's compiler knows it."""
    whole = np.float32(np.int32(x))
    return whole - ONE if whole > x else whole


@inner
def most(work, n, first, last):
    """The greatest number of columns or rows that a point has about it."""
    out = ZERO
    for k in range(n):
        out = max(out, work[last + k] - work[first + k] + ONE)
    return np.int64(out)


@inner
def weigh(work, n, row, column, size):
    """Number and weight of the texel in this row and column of those about each point."""
    for k in range(n):
        across = work[FIRST_U + k] + column
        down = work[FIRST_V + k] + row
        there = (across <= work[LAST_U + k]) & (down <= work[LAST_V + k])
        held = there & (across >= ZERO) & (down >= ZERO) & (across < size) & (down < size)
        work[PLACE + k] = down * size + across if held else -ONE
        across = (across - work[U + k]) * work[PER + k]
        across = ONE - across * across
        down = (down - work[V + k]) * work[PER + k]
        down = ONE - down * down
        weight = down * down * across * across if there else ZERO
        work[WEIGHT + k] = weight
        work[TOTAL + k] += weight


@inner
def sink(work, n, start, layers, stacks):
    """Strands in front of each point in that texel, 0 where there is none."""
    stride = np.uint64(layers + opacity.HEAD + 1)
    for k in range(n):
        place = work[PLACE + k]
        passed = ZERO
        if place >= ZERO:
            passed = opacity.depth_at(work[DEPTH + k], start + np.uint64(np.int64(place)) * stride, layers, stacks)
        work[PASSED + k] = passed


@inner
def dim(work, n, veil):
    """Add the light that strands in that texel take from each point, in red, green and blue."""
    for k in range(n):
        passed = work[PASSED + k]
        if passed > ZERO:
            at = passed / (passed + HALF_WAY) * np.float32(veil.shape[0] - 1)
            j = min(np.int64(at), veil.shape[0] - 2)
            at -= np.float32(j)
            for c in range(3):
                work[LOST + c * W + k] += work[WEIGHT + k] * (veil[j, c] + at * (veil[j + 1, c] - veil[j, c]))
