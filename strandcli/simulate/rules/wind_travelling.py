"""Wind whose gusts travel over the strands, as over a field of grass: `wind` with a wavelength."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...constants import W

HALF = np.float32(0.5)
ONE = np.float32(1)
TWO = np.float32(2)
THREE = np.float32(3)
PULL_X, PULL_Y, PULL_Z, DIRECTION_X, DIRECTION_Y, DIRECTION_Z, GUST, DOWN_X, DOWN_Y, DOWN_Z = range(10)
"""Columns of p: w Δt² without gusts; w / |w|; the share that gusts; mean downwind over the wavelength, 1/m."""
RATE_1, AMPLITUDE_1, PHASE_1, RATE_2, AMPLITUDE_2, PHASE_2, RATE_3, AMPLITUDE_3, PHASE_3 = range(10, 19)
"""Of each of three waves 1 / scale, its amplitude, and its phase at this time."""
PER_LENGTH, BY_ANGLE = 19, 20
"""a and b of the factor a + b / length: (1, 0) as printed, (0, 1) with the length divided out."""


def apply(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """Displace particles by wind whose gusts travel downwind, by the position of each strand's root; p: columns above.

    A pass of the stage "particle" (`rule.Pass`).
    """
    for k in range(W):
        dx = x[k] - parent[k]
        dy = x[W + k] - parent[W + k]
        dz = x[2 * W + k] - parent[2 * W + k]
        cx = p[DIRECTION_Y] * dz - p[DIRECTION_Z] * dy
        cy = p[DIRECTION_Z] * dx - p[DIRECTION_X] * dz
        cz = p[DIRECTION_X] * dy - p[DIRECTION_Y] * dx
        along = p[DOWN_X] * root[k] + p[DOWN_Y] * root[W + k] + p[DOWN_Z] * root[2 * W + k]
        u = p[PHASE_1] - along * p[RATE_1]
        v = p[PHASE_2] - along * p[RATE_2]
        w = p[PHASE_3] - along * p[RATE_3]
        # np.floor: math.floor gives an integer, and a float32 less an integer is a float64
        u = abs(TWO * (u - np.floor(u)) - ONE)
        v = abs(TWO * (v - np.floor(v)) - ONE)
        w = abs(TWO * (w - np.floor(w)) - ONE)
        g = p[AMPLITUDE_1] * (ONE - TWO * u * u * (THREE - TWO * u))
        g += p[AMPLITUDE_2] * (ONE - TWO * v * v * (THREE - TWO * v))
        g += p[AMPLITUDE_3] * (ONE - TWO * w * w * (THREE - TWO * w))
        m = math.sqrt(cx * cx + cy * cy + cz * cz) * (p[PER_LENGTH] + p[BY_ANGLE] / length[k])
        m *= ONE - p[GUST] * HALF * (ONE - g)
        x[k] += p[PULL_X] * m
        x[W + k] += p[PULL_Y] * m
        x[2 * W + k] += p[PULL_Z] * m
