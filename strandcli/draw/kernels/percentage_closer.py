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

from ...jit import function
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
        blur = lights[i, 12] * away * views[one, 13] if flat else ZERO
        if not flat:
            angle = lights[i, 12] if lights[i, 0] == ZERO else lights[i, 12] / max(d, DARK)
            blur = angle * away * views[one, 13] / max(d, DARK)
        reach = min(math.sqrt(max(DISC * blur * blur - TEXEL, LEAST * LEAST)), MOST)
        per = ONE / reach
        left = np.int64(np.ceil(u - reach))
        right = np.int64(np.floor(u + reach))
        top = np.int64(np.ceil(v - reach))
        bottom = np.int64(np.floor(v + reach))
        d -= lights[i, 9]
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
                    if veil is None:
                        red += weight * (ONE - exp(-passed))
                    else:
                        at = passed / (passed + HALF_WAY) * np.float32(veil.shape[0] - 1)
                        k = min(np.int64(at), veil.shape[0] - 2)
                        at -= np.float32(k)
                        red += weight * (veil[k, 0] + at * (veil[k + 1, 0] - veil[k, 0]))
                        green += weight * (veil[k, 1] + at * (veil[k + 1, 1] - veil[k, 1]))
                        blue += weight * (veil[k, 2] + at * (veil[k + 1, 2] - veil[k, 2]))
        if veil is None:
            green = red
            blue = red
        per = ONE / max(total, DARK)
        return ONE - red * per, ONE - green * per, ONE - blue * per
    return ONE, ONE, ONE
