"""Light that comes to a batch of vertices by way of other strands: dual scattering, or one diffuse term (Kajiya and Kay
1989)."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, function
from ....simd import floor, gather4, lane_count, load, pointer, store, store3
from ...common.kernels import batch as row
from ...common.kernels.approximations import clamp, exp
from ...common.kernels.batch import ARRIVES, COLOUR, LX, LY, LZ, RADIANCE, TX, TY, TZ
from ...common.kernels.light_columns import POWER_B, POWER_G, POWER_R
from ...common.kernels.numbers import INV_PI, ONE, ZERO
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
            row.vector_at(work, row.TX, k), row.vector_at(work, row.LX, k), row.vector_at(work, row.EX, k), nodes
        )
        work[row.SIN_L + k] = sin_l
        work[row.COS_L + k] = cos_l
        work[row.SIN_V + k] = sin_v
        work[row.COS_V + k] = cos_v
        work[row.COS_PHI + k] = cos_phi
        work[row.PLACE + k] = place
    look_up(work, n, rows)
    for k in range(n):
        back, through = dual.lobes(
            work[row.SIN_L + k], work[row.COS_L + k], work[row.SIN_V + k], work[row.COS_V + k], work[row.PASSED + k],
            work[row.TABLE + dual.SPREAD * W + k], work[row.TABLE + dual.WIDTH * W + k],
            work[row.TABLE + dual.OWN * W + k],
        )  # fmt: skip
        work[row.RETURNED + k] = back
        work[row.FORWARD + k] = through
    for c in range(3):
        power = lights[one, POWER_R + c]
        per = tables.scale[c]
        for k in range(n):
            s = dual.scattered(
                work[row.PASSED + k], work[row.LEFT + k], exp(-work[row.PASSED + k]), work[row.COS_PHI + k],
                (work[row.RETURNED + k], work[row.FORWARD + k]),
                (work[row.TABLE + (dual.DECAY + c) * W + k], work[row.TABLE + (dual.MIRROR + c) * W + k],
                 work[row.TABLE + (dual.BEAM + c) * W + k], work[row.TABLE + (dual.ON + c) * W + k],
                 work[row.TABLE + (dual.BACK + c) * W + k]),
                (work[row.TABLE + (dual.ROUND + c) * W + k], work[row.TABLE + (dual.COSINE + c) * W + k]),
                work[row.COLOUR + c * W + k] * per,
            )  # fmt: skip
            work[row.RADIANCE + c * W + k] += work[row.UNBLOCKED + k] * power * s


@device
def look_up(work, n, table):
    """Store the rows `TABLE` at the places `PLACE` of the first n vertices; table (n_θ, CHANNELS)."""
    for k in range(n, W):  # the unused lanes of the last vector must read valid nodes
        work[row.PLACE + k] = ZERO
    rows, nodes = pointer(work), pointer(table)
    last = np.float32(table.shape[0] - 2)
    for k in range(0, n, lane_count(rows)):
        place = load(rows, row.PLACE + k)
        i = min(floor(place), last)
        part = place - i
        for c in range(0, row.CHANNELS, 4):
            low = gather4(nodes, c, i, row.CHANNELS, ZERO)
            high = gather4(nodes, c + row.CHANNELS, i, row.CHANNELS, ZERO)
            store3(
                rows, row.TABLE + c * W + k, W,
                low[0] + part * (high[0] - low[0]), low[1] + part * (high[1] - low[1]),
                low[2] + part * (high[2] - low[2]),
            )  # fmt: skip
            store(rows, row.TABLE + (c + 3) * W + k, low[3] + part * (high[3] - low[3]))


@device
def diffuse_light(work, n, lights, i, scale):
    """Add the diffuse term of light number i to the radiance of the first n vertices of a batch; scale:
    `material.diffuse`."""
    for k in range(n):
        d = scale * kajiya_diffuse(work[TX + k], work[TY + k], work[TZ + k], work[LX + k], work[LY + k], work[LZ + k])
        d *= work[ARRIVES + k]
        work[RADIANCE + k] += lights[i, POWER_R] * (d * work[COLOUR + k])
        work[RADIANCE + W + k] += lights[i, POWER_G] * (d * work[COLOUR + W + k])
        work[RADIANCE + 2 * W + k] += lights[i, POWER_B] * (d * work[COLOUR + 2 * W + k])


@function
def kajiya_diffuse(tx, ty, tz, lx, ly, lz):
    """cos θ_l / π, in 1/sr: Kajiya and Kay's (1989) diffuse term, sin(t, l), scaled to bound the light of a mass.

    Radiance = E · material.diffuse · colour · result, the same from everywhere. It stands for light scattered from
    strand to strand, so its bound is set for a mass of strands: an opaque one under a facing light has the exitance
    diffuse · colour · E, as a Lambertian surface of that albedo. (A lone strand in the open returns π times that.)
    """
    s = clamp(tx * lx + ty * ly + tz * lz, -ONE, ONE)
    return np.sqrt(ONE - s * s) * INV_PI
