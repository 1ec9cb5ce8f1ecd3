"""Shadows at a single point, by the kernels that take batches of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from strandcli.constants import W
from strandcli.draw.common.kernels import batch, surface_batch
from strandcli.draw.common.kernels.light_columns import (
    BIAS,
    FIRST_MAP,
    KIND,
    LIGHT_SIZE,
    MAP_COUNT,
    MAP_LAYERS,
    PER_FALL,
)
from strandcli.draw.shadows.kernels import strand_shadows
from strandcli.draw.shadows.kernels.solid_shadows import soft_shadows
from strandcli.draw.shadows.kernels.strand_shadows import ShadowArrays
from strandcli.jit import function

NOTHING = np.zeros(0, np.float32)


@function
def count(work: Any, shadows: Any, one: Any, layers: Any, bias: Any, width: Any, over: Any) -> None:
    """Add the optical depth in front of one vertex."""
    strand_shadows.count_in_front(work, 1, shadows, one, layers, bias, width, over, None)


def soft_visibility(solids: Any, ray: Any, skin: Any, size: Any, point: Any) -> np.float32:
    """The visible share of a disc light past solids; ray: `penumbra.LightRay`; size: sine of the light's angular
    radius, or its radius in metres where ``point`` is 1."""
    work = np.zeros((surface_batch.ROWS, W), np.float32)
    for row, number in zip((batch.X, batch.Y, batch.Z, batch.LX, batch.LY, batch.LZ, batch.REACH), ray, strict=True):
        work[row // W, 0] = number
    work[batch.ARRIVES // W, 0] = 1
    lights = np.zeros((1, 16), np.float32)
    lights[0, KIND], lights[0, LIGHT_SIZE] = point, size
    soft_shadows(work.reshape(-1), 1, lights, 0, solids, skin)
    return np.float32(work[batch.ARRIVES // W, 0])


def at(x: Any, y: Any, z: Any) -> np.ndarray:
    """A batch of one vertex that light arrives at."""
    work = np.zeros((batch.ROWS, W), np.float32)
    work[[row // W for row in (batch.X, batch.Y, batch.Z, batch.ARRIVES)], 0] = x, y, z, 1
    return work.reshape(-1)


def maps_of(lights: Any, i: int) -> range:
    """The numbers of a light's maps."""
    return range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT]))


def minmax_transmittance(
    x: Any, y: Any, z: Any, lights: Any, i: int, texels: Any, starts: Any, sizes: Any, views: Any
) -> float:
    """The share of a light that min/max maps leave at a point."""
    work, shadows = at(x, y, z), ShadowArrays(texels, NOTHING, starts, sizes, views)
    for one in maps_of(lights, i):
        strand_shadows.shade_by_minmax(work, 1, shadows, one, lights[i, BIAS])
    return float(work[batch.ARRIVES])


def optical_depth(
    x: Any, y: Any, z: Any, width: Any, lights: Any, i: int, stacks: Any, starts: Any, sizes: Any, views: Any
) -> float:
    """τ between a light with opacity maps and a point; width: mean width of strands, metres, 0 for a point on none."""
    work, shadows = at(x, y, z), ShadowArrays(NOTHING.reshape(0, 2), stacks, starts, sizes, views)
    for one in maps_of(lights, i):
        count(work, shadows, one, int(lights[i, MAP_LAYERS]), lights[i, BIAS], width, lights[i, PER_FALL])
    return float(work[batch.PASSED])


def transmittance(*where: Any) -> float:
    """e^-τ; arguments as in `optical_depth`."""
    return float(np.exp(-optical_depth(*where)))
