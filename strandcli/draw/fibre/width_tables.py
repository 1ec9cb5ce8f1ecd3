"""Tables of a strand's light across its width: what each column of the offset h departs from the average.

How these are used: `strandcli.draw.coverage.width_profiles`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...scene.model import Material
from ..coverage.kernels.column_light import COLUMNS
from . import chiang, marschner
from .kernels.width_highlights import CHANNELS
from .pigment import absorption_of

N_THETA, N_PHI, OFFSETS = 24, 49, 8
"""Nodes of the tables, and offsets a column."""


def columns_of(material: Material) -> NDArray[np.float32] | None:
    """(n_θ, n_φ, columns, 8): what the azimuthal functions of R, TT rgb and TRT rgb depart from their averages in each
    column of h, light on the side where h is positive. θ is what the model's tables have, φ is in [0, π]. Lobes
    narrower than a cell are drawn as wide as one. None where there are no highlights."""
    if material.specular == 0:
        return None
    theta = np.minimum(np.linspace(0.0, 0.5 * np.pi, N_THETA), 0.5 * np.pi - 1e-4)
    phi = np.linspace(0.0, np.pi, N_PHI)
    count = COLUMNS * OFFSETS
    offset = (np.arange(count) + 0.5) * (2.0 / count) - 1.0
    gamma = -np.arcsin(offset)  # a ray that enters on the side of b is at a negative angle in Φ
    step = np.pi / (N_PHI - 1)
    if material.model == "chiang":
        sigma = absorption_of(material, material.beta_n)
        rays, _, out = chiang.passages(theta, gamma, material.eta, sigma)
        s = max(chiang.logistic_scale(material.beta_n), 0.5 * step)
        scales = np.ones(7)
    else:
        sigma = absorption_of(material, marschner.azimuthal_beta(material.azimuthal))
        rays, _, out = marschner.passages(theta, gamma, material.eta, sigma)
        s = max(math.radians(material.azimuthal), 0.75 * step)
        scales = np.repeat(marschner.peaks(material), (1, 3, 3))
    table = np.zeros((N_THETA, N_PHI, COLUMNS, CHANNELS), np.float32)
    for lobe, channels in enumerate(((0,), (1, 2, 3), (4, 5, 6))):
        apart = phi[None, :, None] - out[:, lobe, None]  # (θ, φ, rays)
        apart -= 2.0 * np.pi * np.round(apart / (2.0 * np.pi))
        seen = _logistic(apart, s) if material.model == "chiang" else _gaussian(apart, s)
        for c in channels:
            light = (seen * rays[:, None, c]).reshape(N_THETA, N_PHI, COLUMNS, OFFSETS).mean(-1)
            table[..., c] = scales[c] * (light - light.mean(-1, keepdims=True))
    return table


def _logistic(angle: NDArray[np.float64], s: float) -> NDArray[np.float64]:
    fall = np.exp(-np.abs(angle) / s)
    return np.asarray(fall / (s * (1.0 + fall) ** 2) / math.tanh(0.5 * np.pi / s))


def _gaussian(angle: NDArray[np.float64], deviation: float) -> NDArray[np.float64]:
    turns = [np.exp(-0.5 * ((angle + turn) / deviation) ** 2) for turn in (-2.0 * np.pi, 0.0, 2.0 * np.pi)]
    return np.asarray(sum(turns) / (math.sqrt(2.0 * np.pi) * deviation))
