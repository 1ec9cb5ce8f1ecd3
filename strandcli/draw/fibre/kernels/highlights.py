"""The lobes of a strand at a batch of vertices."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device
from ...common.kernels.batch import (
    ARRIVES,
    EX,
    EXTRA,
    EY,
    EZ,
    LX,
    LY,
    LZ,
    NODE_X,
    NODE_Y,
    RADIANCE,
    REST,
    TRT,
    TT,
    TX,
    TY,
    TZ,
    R,
)
from ...common.kernels.light_columns import POWER_B, POWER_G, POWER_R
from . import chiang, marschner
from .lobes import azimuthal

ZERO = np.float32(0.0)


@device
def highlights(work, n, lights, i, lobes, fibre, nodes, paths):
    """Light that a strand scatters once: by Marschner's model where there are `lobes`, by Chiang's where there is a
    `fibre`; the other one is None."""
    if lobes is not None:
        for k in range(n):
            x, y, r, tt, trt = marschner.longitudinal(
                work[TX + k], work[TY + k], work[TZ + k], work[LX + k], work[LY + k], work[LZ + k],
                work[EX + k], work[EY + k], work[EZ + k], lobes,
            )  # fmt: skip
            work[NODE_X + k] = x
            work[NODE_Y + k] = y
            work[R + k] = r
            work[TT + k] = tt
            work[TRT + k] = trt
    if fibre is not None:
        for k in range(n):
            x, y, r, tt, trt, rest = chiang.longitudinal(
                work[TX + k], work[TY + k], work[TZ + k], work[LX + k], work[LY + k], work[LZ + k],
                work[EX + k], work[EY + k], work[EZ + k], fibre,
            )  # fmt: skip
            work[NODE_X + k] = x
            work[NODE_Y + k] = y
            work[R + k] = r
            work[TT + k] = tt
            work[TRT + k] = trt
            work[REST + k] = rest
    for k in range(n):
        arrives = work[ARRIVES + k]
        if arrives > ZERO:
            r, g, b = azimuthal(
                work[NODE_X + k], work[NODE_Y + k], work[R + k], work[TT + k], work[TRT + k],
                None if fibre is None else work[REST + k], nodes, paths,
                work[EXTRA + k], work[EXTRA + W + k], work[EXTRA + 2 * W + k],
            )  # fmt: skip
            work[RADIANCE + k] += arrives * lights[i, POWER_R] * r
            work[RADIANCE + W + k] += arrives * lights[i, POWER_G] * g
            work[RADIANCE + 2 * W + k] += arrives * lights[i, POWER_B] * b
