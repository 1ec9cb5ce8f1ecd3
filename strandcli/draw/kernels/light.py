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
def toward(lights, i, x, y, z):
    """Unit direction to light number i, its distance, and its irradiance's falloff at a point."""
    if lights[i, 0] == ZERO:
        return lights[i, 1], lights[i, 2], lights[i, 3], FAR, ONE
    lx = lights[i, 1] - x
    ly = lights[i, 2] - y
    lz = lights[i, 3] - z
    square = max(lx * lx + ly * ly + lz * lz, TINY)
    size = math.sqrt(square)
    return lx / size, ly / size, lz / size, size, ONE / square
