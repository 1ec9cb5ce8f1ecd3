"""Tables of dual scattering (Zinke, Yuksel, Weber & Keyser 2008): light that reaches a strand through others, and what
the strands about it send back. Built once per material, over the inclination of the light.

The number N of strands between light and point is taken as Poisson distributed with the mean τ that an opacity map
holds. Then e^-τ of the light arrives unscattered, and E[a^N; N ≥ 1] = e^(−τ (1 − a)) − e^-τ has passed through strands
only forward, a being the part of its light that a strand sends on into the half space away from the light. The paper
takes N at its mean. Each passage widens the light's inclination by the variance v.

Backward: the paper's averages over an even number of forward scatterings about one (A_1) or three (A_3) backward ones,

    A_b = a_b a_f² / (1 − a_f²) + a_b³ a_f² / (1 − a_f²)³,

with its mean shift and width (eqs. 13 … 17). They go out by d'Eon's lobe and (1 + cos φ) / 2π, whose integral is 1: the
paper has a constant over the half space toward the light, with an edge at φ = 90°. Density factors d_f, d_b are its .7.

Lobes are Chiang's whichever model draws the highlights. Where colours vary, tables are those of the mean absorption; a
vertex scales them with the colour of a mass of its own over that of the mean.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from . import chiang
from .kernels import dual as kernel
from .kernels.lobes import REST, TRT, TT, R
from .pigment import absorption_of, mass_colour, tint, varies

if TYPE_CHECKING:
    from ..scene.model import Material

N_THETA, N_PHI = 64, 257
DENSITY = 0.7
MOST = 0.999
"""Part of light that a strand may send forward: at 1 nothing would ever leave a mass of them."""


@dataclass(frozen=True, slots=True)
class DualTables:
    """What the kernel reads, float32.

    rows: (n_θ, 16) over θ_l in [0, π/2] (channels named in the kernel's file); it is even.
    scale: (3,) one over the colour of a mass with the tables' absorption.
    """

    rows: NDArray[np.float32]
    scale: NDArray[np.float32]


def build_tables(material: Material, roughness: float) -> DualTables:
    """Tables for ``material``; ``roughness`` is the β_n by which colours and absorption correspond."""
    sigma = absorption_of(material, roughness)
    if varies(material):
        along, tone = np.meshgrid(np.linspace(0, 1, 9), np.linspace(-1, 1, 33))
        sigma = np.sqrt(tint(material, roughness, along, tone)[1]).mean((0, 1)) ** 2
    theta = np.minimum(np.linspace(0.0, 0.5 * np.pi, N_THETA), 0.5 * np.pi - 1e-4)
    s = chiang.logistic_scale(material.beta_n)
    nodes = chiang.azimuthal(theta, N_PHI, material.eta, sigma, s)[0].astype(np.float64)
    # four lobes in rgb
    n = np.stack(
        [
            np.repeat(nodes[..., R : R + 1], 3, -1),
            nodes[..., TT : TT + 3],
            nodes[..., TRT : TRT + 3],
            nodes[..., REST : REST + 3],
        ],
        2,
    )
    phi = np.linspace(0.0, np.pi, N_PHI)
    weights = np.full(N_PHI, 2.0 * np.pi / (N_PHI - 1))
    weights[[0, -1]] *= 0.5
    half = N_PHI // 2
    back = np.where(np.arange(N_PHI) < half, weights, 0.0)
    back[half] = 0.5 * weights[half]
    # (n_θ, lobes, rgb)
    behind = np.einsum("j,ijpc->ipc", back, n)
    ahead = np.einsum("j,ijpc->ipc", weights - back, n)
    a_f = np.minimum(ahead.sum(1), MOST)
    a_b = np.minimum(behind.sum(1), 1.0 - a_f)
    v = chiang.variances(material.beta_m)
    shifts = -chiang.tilts(material.tilt)
    f, b = ahead.mean(-1), behind.mean(-1)
    v_f, v_b = (f @ v) / f.sum(1), (b @ v) / b.sum(1)
    shift_f, shift_b = (f @ shifts) / f.sum(1), (b @ shifts) / b.sum(1)

    left = 1.0 - a_f**2
    backward = a_b * a_f**2 / left + a_b**3 * a_f**2 / left**3
    mean_f, mean_b = a_f.mean(1), a_b.mean(1)
    rest = 1.0 - mean_f**2
    shift = (
        shift_b * (1.0 - 2.0 * mean_b**2 / rest**2) + shift_f * (2.0 * rest**2 + 4.0 * mean_f**2 * mean_b**2) / rest**3
    )
    width = (
        (1.0 + DENSITY * mean_f**2)
        * (mean_b * np.sqrt(2.0 * v_f + v_b) + mean_b**3 * np.sqrt(2.0 * v_f + 3.0 * v_b))
        / (mean_b + mean_b**3 * (2.0 * np.sqrt(v_f) + 3.0 * np.sqrt(v_b)))
    )

    every = ahead + behind
    cosine = np.einsum("j,ijpc->ic", weights * np.cos(phi), n)
    rows = np.zeros((N_THETA, kernel.CHANNELS), np.float32)
    rows[:, kernel.STOPPED : kernel.STOPPED + 3] = 1.0 - a_f
    rows[:, kernel.BACKWARD : kernel.BACKWARD + 3] = np.minimum(backward, 1.0)
    rows[:, kernel.ROUND : kernel.ROUND + 3] = every.sum(1) / (2.0 * np.pi)
    rows[:, kernel.COSINE : kernel.COSINE + 3] = cosine * 2.0 / np.pi**2
    rows[:, kernel.SPREAD] = v_f
    rows[:, kernel.WIDTH] = width**2
    rows[:, kernel.SHIFT] = np.clip(shift, -math.pi / 4, math.pi / 4)
    rows[:, kernel.OWN] = (every.mean(-1) @ v) / every.mean(-1).sum(1)
    return DualTables(rows, (1.0 / np.maximum(mass_colour(sigma, roughness), 1e-3)).astype(np.float32))
