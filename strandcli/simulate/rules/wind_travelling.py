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


def apply(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """Gusts that travel downwind, by the place of each strand's root.

    p[0:3]: w Δt² without gusts; p[3:6]: w / |w|; p[6]: the gust's share; p[7:10]: mean downwind unit vector over the
    wavelength; then for each of three waves: p[10 + 3 j] 1 / scale, p[11 + 3 j] amplitude, p[12 + 3 j] phase at this
    time; p[19], p[20]: factors a + b / length that make the pull per length or by angle.
    """
    for k in range(W):
        dx = x[k] - parent[k]
        dy = x[W + k] - parent[W + k]
        dz = x[2 * W + k] - parent[2 * W + k]
        cx = p[4] * dz - p[5] * dy
        cy = p[5] * dx - p[3] * dz
        cz = p[3] * dy - p[4] * dx
        along = p[7] * root[k] + p[8] * root[W + k] + p[9] * root[2 * W + k]
        u = p[12] - along * p[10]
        v = p[15] - along * p[13]
        w = p[18] - along * p[16]
        # np.floor: math.floor gives an integer, and a float32 less an integer is a float64
        u = abs(TWO * (u - np.floor(u)) - ONE)
        v = abs(TWO * (v - np.floor(v)) - ONE)
        w = abs(TWO * (w - np.floor(w)) - ONE)
        g = p[11] * (ONE - TWO * u * u * (THREE - TWO * u))
        g += p[14] * (ONE - TWO * v * v * (THREE - TWO * v))
        g += p[17] * (ONE - TWO * w * w * (THREE - TWO * w))
        m = math.sqrt(cx * cx + cy * cy + cz * cz) * (p[19] + p[20] / length[k])
        m *= ONE - p[6] * HALF * (ONE - g)
        x[k] += p[0] * m
        x[W + k] += p[1] * m
        x[2 * W + k] += p[2] * m
