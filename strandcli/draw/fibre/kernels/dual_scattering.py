"""Light that comes to a batch of vertices by way of other strands: dual scattering."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device
from ...common.kernels.approximations import exp
from ...common.kernels.batch import (
    CHANNELS,
    COLOUR,
    COS_L,
    COS_PHI,
    COS_V,
    EX,
    EY,
    EZ,
    FORWARD,
    LEFT,
    LX,
    LY,
    LZ,
    PASSED,
    PLACE,
    RADIANCE,
    RETURNED,
    SIN_L,
    SIN_V,
    TABLE,
    TX,
    TY,
    TZ,
    UNBLOCKED,
)
from ...common.kernels.light_columns import POWER_R
from . import dual


@device
def dual_scattering(work, n, lights, one, tables):
    """Add the light of number `one` that comes by way of other strands, at the first n vertices of a batch.

    work: rows of `batch`, of which those of directions, strands before and behind, and of what arrives without strands
    are read; tables: `dual.DualArrays`.
    """
    rows = tables.rows
    nodes = rows.shape[0]
    for k in range(n):
        sin_l, cos_l, sin_v, cos_v, cos_phi, place = dual.angles(
            work[TX + k], work[TY + k], work[TZ + k], work[LX + k], work[LY + k], work[LZ + k],
            work[EX + k], work[EY + k], work[EZ + k], nodes,
        )  # fmt: skip
        work[SIN_L + k] = sin_l
        work[COS_L + k] = cos_l
        work[SIN_V + k] = sin_v
        work[COS_V + k] = cos_v
        work[COS_PHI + k] = cos_phi
        work[PLACE + k] = place
    for k in range(n):
        i = min(np.int64(work[PLACE + k]), nodes - 2)
        part = work[PLACE + k] - np.float32(i)
        for c in range(CHANNELS):
            low = rows[i, c]
            work[TABLE + c * W + k] = low + part * (rows[i + 1, c] - low)
    for k in range(n):
        back, through = dual.lobes(
            work[SIN_L + k], work[COS_L + k], work[SIN_V + k], work[COS_V + k], work[PASSED + k],
            work[TABLE + dual.SPREAD * W + k], work[TABLE + dual.WIDTH * W + k], work[TABLE + dual.OWN * W + k],
        )  # fmt: skip
        work[RETURNED + k] = back
        work[FORWARD + k] = through
    for c in range(3):
        power = lights[one, POWER_R + c]
        per = tables.scale[c]
        for k in range(n):
            s = dual.scattered(
                work[PASSED + k], work[LEFT + k], exp(-work[PASSED + k]), work[COS_PHI + k],
                (work[RETURNED + k], work[FORWARD + k]),
                (work[TABLE + (dual.DECAY + c) * W + k], work[TABLE + (dual.MIRROR + c) * W + k],
                 work[TABLE + (dual.BEAM + c) * W + k], work[TABLE + (dual.ON + c) * W + k],
                 work[TABLE + (dual.BACK + c) * W + k]),
                (work[TABLE + (dual.ROUND + c) * W + k], work[TABLE + (dual.COSINE + c) * W + k]),
                work[COLOUR + c * W + k] * per,
            )  # fmt: skip
            work[RADIANCE + c * W + k] += work[UNBLOCKED + k] * power * s
