"""Light that goes from strand to strand, as one diffuse term (Kajiya and Kay 1989)."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, function
from ...common.kernels.approximations import clamp
from ...common.kernels.batch import ARRIVES, COLOUR, LX, LY, LZ, RADIANCE, TX, TY, TZ
from ...common.kernels.light_columns import POWER_B, POWER_G, POWER_R
from ...common.kernels.numbers import INV_PI, ONE


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
