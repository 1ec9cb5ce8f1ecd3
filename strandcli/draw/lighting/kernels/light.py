"""Directions and radiance of lights at a point, and ambient light on a batch of vertices."""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, inlined
from ....jit.indices import FIRST, SECOND
from ....simd import lane_count, load, load3, pointer, sqrt, store, store3
from ...common.kernels.batch import ARRIVES, COLOUR, INSIDE, LX, RADIANCE, REACH, TX, X
from ...common.kernels.light_columns import KIND, PLACE_X, PLACE_Y, PLACE_Z
from ...common.kernels.numbers import ONE, THREE, ZERO
from .occlusion import sky_visibilities

TINY = np.float32(1e-30)
FAR = np.float32(1e30)
STRAND, SURFACE = FIRST, SECOND
"""Rows of environment light: on a white strand, by its tangent; on a white surface, by its normal."""


@device
def toward(lights, i, point):
    """Return the unit direction from a point to light number i, its distance in metres, and its falloff."""
    if lights[i, KIND] == ZERO:
        return lights[i, PLACE_X], lights[i, PLACE_Y], lights[i, PLACE_Z], FAR, ONE
    lx = lights[i, PLACE_X] - point[0]
    ly = lights[i, PLACE_Y] - point[1]
    lz = lights[i, PLACE_Z] - point[2]
    square = max(lx * lx + ly * ly + lz * lz, TINY)
    size = math.sqrt(square)
    return lx / size, ly / size, lz / size, size, ONE / square


@device
def aim(work, n, lights, i):
    """Store direction and distance to light number i, and its falloff in `ARRIVES`."""
    rows = pointer(work)
    px, py, pz = lights[i, PLACE_X], lights[i, PLACE_Y], lights[i, PLACE_Z]
    for k in range(0, n, lane_count(rows)):
        store(rows, INSIDE + k, ZERO)
        if lights[i, KIND] == ZERO:
            store3(rows, LX + k, W, px, py, pz)
            store(rows, REACH + k, FAR)
            store(rows, ARRIVES + k, ONE)
        else:
            x, y, z = load3(rows, X + k, W)
            x, y, z = px - x, py - y, pz - z
            square = max(x * x + y * y + z * z, TINY)
            size = sqrt(square)
            store3(rows, LX + k, W, x / size, y / size, z / size)
            store(rows, REACH + k, size)
            store(rows, ARRIVES + k, ONE / square)


@inlined
def around(sky, which, c, x, y, z):
    """Return the radiance in channel c of a white `STRAND` by its unit tangent, or of a white `SURFACE` by its unit
    normal, in environment light; at least 0. sky (2, 9, 3): from `strandcli.draw.lighting.environment`."""
    even = sky[which, 0, c] + sky[which, 4, c] * x * y + sky[which, 5, c] * y * z
    even += sky[which, 6, c] * (THREE * z * z - ONE) + sky[which, 7, c] * x * z + sky[which, 8, c] * (x * x - y * y)
    return max(even + sky[which, 1, c] * x + sky[which, 2, c] * y + sky[which, 3, c] * z, ZERO)


LEAST_SHARE = np.float32(1e-12)
FACE = np.float32((1.0 - math.log(2.0)) / 2.0)
"""Ā: mean sky visibility of the strands seen at the surface of a mass."""


@device
def ambient_light(work, n, surround):
    """Set the rows `RADIANCE` of the first n vertices of a batch to that in ambient light; surround: `inputs.Surround`.

    The colour C of a strand is that of a mass of strands, including multiple scattering between them. Where the share A
    of the sky is visible and equal strands occlude the rest, a strand of albedo a receives J = A + (1 − A) a J (the
    interreflection of Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion") and
    reflects a J. At the surface of a half-space of strands, the mean of A over what the eye sees is Ā = ∫ e^-τ E₂(τ) /
    2 dτ, and the reflected colour is C. That determines a, and a J = C A / (C A + Ā (1 − C)). So a mass keeps its
    colour; its outermost strands are brighter and the inner ones darker, the more so the darker the colour.
    """
    ambient, sky = surround.ambient, surround.sky
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        tx, ty, tz = load3(rows, TX + k, W)
        for c in range(3):
            colour = load(rows, COLOUR + c * W + k)
            store(rows, RADIANCE + c * W + k, ambient[c] * colour)
            if sky.shape[0] > 0:
                whole = around(sky, STRAND, c, tx, ty, tz)
                store(rows, RADIANCE + c * W + k, load(rows, RADIANCE + c * W + k) + whole * colour)
    if surround.volume.shape[0] > 0:
        for k in range(0, n, lane_count(rows)):
            share = sky_visibilities(surround.volume, surround.box, load3(rows, X + k, W), None)
            for c in range(3):
                colour = min(load(rows, COLOUR + c * W + k), ONE)
                light = load(rows, RADIANCE + c * W + k)
                light = light * (share / max(colour * share + FACE * (ONE - colour), LEAST_SHARE))
                store(rows, RADIANCE + c * W + k, light)
