"""Directions and radiance of lights at a point."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, function
from ....jit.indices import FIRST, SECOND
from ...common.kernels.light_columns import KIND, PLACE_X, PLACE_Y, PLACE_Z
from ...common.kernels.numbers import ONE, THREE, ZERO

TINY = np.float32(1e-30)
FAR = np.float32(1e30)
STRAND, SURFACE = FIRST, SECOND
"""Rows of environment light: on a white strand, by its tangent; on a white surface, by its normal."""


@device
def toward(lights, i, point):
    """Return the unit direction from a point to light number i, its distance in metres, and its falloff."""
    if lights[i, KIND] == ZERO:
        return lights[i, PLACE_X], lights[i, PLACE_Y], lights[i, PLACE_Z], FAR, ONE
    lx = lights[i, PLACE_X] - point[0]
    ly = lights[i, PLACE_Y] - point[1]
    lz = lights[i, PLACE_Z] - point[2]
    square = max(lx * lx + ly * ly + lz * lz, TINY)
    size = math.sqrt(square)
    return lx / size, ly / size, lz / size, size, ONE / square


@function
def around(sky, which, c, x, y, z):
    """Return the radiance in channel c of a white `STRAND` by its unit tangent, or of a white `SURFACE` by its unit
    normal, in environment light; at least 0. sky (2, 9, 3): from `strandcli.draw.lighting.environment`."""
    even = sky[which, 0, c] + sky[which, 4, c] * x * y + sky[which, 5, c] * y * z
    even += sky[which, 6, c] * (THREE * z * z - ONE) + sky[which, 7, c] * x * z + sky[which, 8, c] * (x * x - y * y)
    return max(even + sky[which, 1, c] * x + sky[which, 2, c] * y + sky[which, 3, c] * z, ZERO)
