"""Lights as kernels read them."""

from __future__ import annotations

import math

import numpy as np

from ...jit import function

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
THREE = np.float32(3.0)
TINY = np.float32(1e-30)
FAR = np.float32(1e30)


@function
def toward(light, x, y, z):
    """Unit direction to a light, its distance, and its irradiance's falloff at a point."""
    if light[0] == ZERO:
        return light[1], light[2], light[3], FAR, ONE
    lx = light[1] - x
    ly = light[2] - y
    lz = light[3] - z
    square = max(lx * lx + ly * ly + lz * lz, TINY)
    size = math.sqrt(square)
    return lx / size, ly / size, lz / size, size, ONE / square


@function
def around(sky, which, c, x, y, z):
    """Radiance in channel c of something white that lies in the sky's light, not negative: strands (which = 0) by their
    unit tangent, surfaces (1) by their unit normal. sky (2, 9, 3) float32 of `strandcli.draw.environment`."""
    s = sky[which]
    even = s[0, c] + s[4, c] * x * y + s[5, c] * y * z + s[6, c] * (THREE * z * z - ONE) + s[7, c] * x * z
    even += s[8, c] * (x * x - y * y)
    return max(even + s[1, c] * x + s[2, c] * y + s[3, c] * z, ZERO)
