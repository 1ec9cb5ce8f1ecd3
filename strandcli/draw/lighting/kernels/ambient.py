"""Light from everywhere on a batch of vertices.

The colour C of a strand is that of a mass of them, with all light that goes from strand to strand. Where only the share
A of the sky is seen and the rest is strands as dark as this one, a strand of albedo a is lit by J = A + (1 − A) a J
(the interreflection of Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion") and shows
a J. On the face of a mass that has no end, A is Ā = ∫ e^-τ E₂(τ) / 2 dτ on average over what is seen of it, and it
shows C: that gives a, and a J = C A / (C A + Ā (1 − C)). So a mass keeps its colour, its outermost strands are brighter
and the strands in it darker, the more so the darker they are.
"""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device
from ...common.kernels.batch import COLOUR, RADIANCE, TX, TY, TZ, X, Y, Z
from .light import around
from .occlusion import seen

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
FACE = np.float32((1.0 - math.log(2.0)) / 2.0)
"""Ā: share of the sky that what is seen of a mass' face sees."""


@device
def ambient_light(work, n, surround):
    """Radiance of the first n vertices of a batch in the light from everywhere, `inputs.Surround`."""
    ambient, sky = surround.ambient, surround.sky
    for c in range(3):
        for k in range(n):
            work[RADIANCE + c * W + k] = ambient[c] * work[COLOUR + c * W + k]
    if sky.shape[0] > 0:
        for c in range(3):
            for k in range(n):
                whole = around(sky, 0, c, work[TX + k], work[TY + k], work[TZ + k])
                work[RADIANCE + c * W + k] += whole * work[COLOUR + c * W + k]
    if surround.volume.shape[0] > 0:
        for k in range(n):
            share = seen(surround.volume, surround.box, work[X + k], work[Y + k], work[Z + k], ZERO, ZERO, ZERO)
            for c in range(3):
                colour = min(work[COLOUR + c * W + k], ONE)
                work[RADIANCE + c * W + k] *= share / max(colour * share + FACE * (ONE - colour), TINY)
