"""Shadows of strands on solids, from deep opacity maps.

On strands a texel's steps drown among strands; on smooth skin each shows as a square. So here what is left of the light
is averaged over the texels about a point (percentage-closer filtering, Reeves, Salesin & Cook 1987), by weights that
fall smoothly to nothing at R texels, (1 − (x / R)²)² along each side. R is a texel and a half at the least, where they
are next to a quadratic spline, and more where the light has a size: the shadow of strands at a distance D is blurred by
a disc of the light's angular radius times D, of which a texel itself is a part. D is the mean distance of the strands
that hide the light, by how much each texel hides, over every other texel as far as strands in the map's middle would
blur (Fernando 2005): what touches the skin is blurred little, however far away the rest of the groom is.

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

from ...jit import function, inner
from . import opacity
from .approximations import exp
from .dual import HALF_WAY
from .shadow import texel_of

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
FEW = np.float32(1e-3)
"""Weight of strands that hide next to nothing."""
STEP = 2
"""Texels from one that is asked for its strands' distance to the next."""
SHARE = np.float32(1 / STEP)
CLOUD = np.float32(1 / 16)
"""Of a map's width, the w of light that goes on."""


@function
def left(x, y, z, lights, i, veil, stacks, starts, sizes, views):
    """Share of light number i, in red, green and blue, that strands leave a point of a solid.

    As `opacity.optical_depth`; lights [12]: the light's size, of `strandcli.draw.shading.pack_lights`; veil (n, 3): of
    `strandcli.draw.dual.veil_of`, None where strands shade in grey and by e^-τ alone.
    """
    layers = np.int64(lights[i, 10])
    stride = layers + opacity.HEAD + 1
    for one in range(int(lights[i, 7]), int(lights[i, 7] + lights[i, 8])):
        u, v, d = texel_of(x, y, z, views, one)
        size = sizes[one]
        edge = np.float32(size - 1)
        flat = views[one, 12] == ZERO
        # beside a perspective map begins the next one of the same light
        room = MOST if flat else ZERO
        if d < views[one, 14] or u < -room or v < -room or u >= edge + room or v >= edge + room:
            continue
        away = max(d - views[one, 14] - HALF * views[one, 19], ZERO)
        blur = lights[i, 12] * views[one, 13]
        scale = ONE / views[one, 13]
        if not flat:
            angle = lights[i, 12] if lights[i, 0] == ZERO else lights[i, 12] / max(d, DARK)
            blur = angle * views[one, 13] / max(d, DARK)
            scale *= d
        d -= lights[i, 9]
        reach = reach_of(blur * away)
        if reach > LEAST:
            reach = reach_of(blur * distance(u, v, d, reach, away, size, starts[one], layers, stacks))
        cloud = CLOUD * np.float32(size) * scale
        per = ONE / reach
        left = np.int64(np.ceil(u - reach))
        right = np.int64(np.floor(u + reach))
        top = np.int64(np.ceil(v - reach))
        bottom = np.int64(np.floor(v + reach))
        total = ZERO
        red = ZERO
        green = ZERO
        blue = ZERO
        for row in range(top, bottom + 1):
            down = (np.float32(row) - v) * per
            down = ONE - down * down
            for column in range(left, right + 1):
                across = (np.float32(column) - u) * per
                across = ONE - across * across
                weight = down * down * across * across
                total += weight
                if row >= 0 and column >= 0 and row < size and column < size:
                    base = np.uint64(starts[one] + (row * size + column) * stride)
                    passed = opacity.depth_at(d, base, layers, stacks)
                    if passed <= ZERO:
                        continue
                    hidden = ONE - exp(-passed)
                    if veil is None:
                        red += weight * hidden
                    else:
                        at = passed / (passed + HALF_WAY) * np.float32(veil.shape[0] - 1)
                        k = min(np.int64(at), veil.shape[0] - 2)
                        at -= np.float32(k)
                        gap = max(d - far_end(base, layers, stacks), ZERO)
                        near = weight * cloud / (cloud + gap)
                        other = (weight - near) * hidden
                        red += near * (veil[k, 0] + at * (veil[k + 1, 0] - veil[k, 0])) + other
                        green += near * (veil[k, 1] + at * (veil[k + 1, 1] - veil[k, 1])) + other
                        blue += near * (veil[k, 2] + at * (veil[k + 1, 2] - veil[k, 2])) + other
        if veil is None:
            green = red
            blue = red
        per = ONE / max(total, DARK)
        return ONE - red * per, ONE - green * per, ONE - blue * per
    return ONE, ONE, ONE


@inner
def reach_of(blur):
    """Texels to each side over which a disc of so many texels is averaged."""
    return min(math.sqrt(max(DISC * blur * blur - TEXEL, LEAST * LEAST)), MOST)


@inner
def far_end(base, layers, stacks):
    """Depth of the farthest strand in the texel that begins at `base`, in which there are some."""
    return stacks[base] + np.float32(layers) / stacks[base + np.uint64(1)]


@inner
def distance(u, v, d, reach, away, size, start, layers, stacks):
    """Mean distance from depth d of strands within `reach` texels of (u, v) that hide the light, metres; `away` where
    there are none."""
    per = ONE / reach
    stride = layers + opacity.HEAD + 1
    weights = FEW
    total = FEW * away
    for row in range(STEP * np.int64(np.ceil((v - reach) * SHARE)), np.int64(np.floor(v + reach)) + 1, STEP):
        down = (np.float32(row) - v) * per
        down = ONE - down * down
        for column in range(STEP * np.int64(np.ceil((u - reach) * SHARE)), np.int64(np.floor(u + reach)) + 1, STEP):
            if row >= 0 and column >= 0 and row < size and column < size:
                base = np.uint64(start + (row * size + column) * stride)
                passed = opacity.depth_at(d, base, layers, stacks)
                if passed > ZERO:
                    across = (np.float32(column) - u) * per
                    across = ONE - across * across
                    weight = down * down * across * across * passed / (passed + ONE)
                    weights += weight
                    total += weight * (d - HALF * (stacks[base] + min(far_end(base, layers, stacks), d)))
    return total / weights
