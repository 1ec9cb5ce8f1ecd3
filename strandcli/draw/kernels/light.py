"""Lights as kernels read them."""

from __future__ import annotations

import math

import numpy as np

from ...jit import function

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
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
