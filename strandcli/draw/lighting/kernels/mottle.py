"""Patches on solids, for batches of points of `shade_surfaces`."""

from __future__ import annotations

import numpy as np

from ....jit import device
from ...common.kernels.batch import X, Y, Z
from ...common.kernels.surface_batch import ACROSS, TONE, UNDER
from ...solids.kernels import coat

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
INF = np.float32(np.inf)


@device
def mottle(work, n, strength, grain):
    """Multiply the light under a coat by that of patches; grain: width of the largest, metres."""
    for k in range(n):
        work[TONE + k] = ZERO
    size, weight = grain, HALF
    for octave in range(coat.OCTAVES):
        least = INF
        for k in range(n):
            least = min(least, work[ACROSS + k])
        if least < size:  # finer octaves are not shown at all
            for k in range(n):
                work[TONE + k] = coat.add_octave(
                    work[TONE + k], work[X + k], work[Y + k], work[Z + k], size, work[ACROSS + k], weight,
                    np.uint32(octave),
                )  # fmt: skip
        size *= HALF
        weight *= coat.FAINTER
    for k in range(n):
        work[UNDER + k] *= ONE + strength * min(max(work[TONE + k], -ONE), ONE)
