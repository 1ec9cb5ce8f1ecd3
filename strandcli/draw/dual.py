"""Tables of dual scattering: light that reaches a strand through others, and what the strands about it send back.
Built once per material, over the inclination of the light.

As Zinke, Yuksel, Weber & Keyser (2008) do, only two ways are told apart, away from the light and back to it. Strands
are met at random, τ of them on average as an opacity map holds it, so that e^-τ of the light arrives unscattered. Of
all that goes on, D, and all that comes back, U, a strand's absorption and scattering make two streams (Schuster 1905):

    dD/dτ = −k₁ D + c₁ U,    dU/dτ = k₂ U − c₂ D,    D = 1 at the light, U = 0 behind the last strand.

D is taken to keep its way, so that k₁ = 1 − a_f and c₂ = a_b, the parts of light across it that a strand sends on and
back. U is taken to come evenly from the half circle behind the strand. Such light meets π / 2 times as many strands,
and of what they scatter by an angle δ the part |δ| / π changes over to D: c₁ = π/2 Σ |δ| / π, k₂ = π/2 (1 − a) + c₁.
Both streams are sums of e^(λτ); with r the U over D of each,

    D = e^(λ₋ τ) (1 − q g) / (1 − q g e^(−Δτ)),    U = r₋ e^(λ₋ τ) (1 − g) / (1 − q g e^(−Δτ)),

Δ = λ₊ − λ₋, q = r₋ / r₊, g = e^(−Δ τ') where τ' strands are still to come. Where nothing is sent back D is
e^(−(1 − a_f) τ), the paper's forward scattering for a random number of strands. The paper's backward scattering is that
of endless hair with one or three reflections, times a density factor of .7; here hair ends where it does, every
reflection counts, and there is no factor. Each passage widens the light's inclination by the variance v, as in the
paper. Nothing goes sideways: the dark side of dense hair gets too little.

A strand answers to D − e^-τ as evenly spread over the half circle about the light, and to U over the one behind it, by
the mean and the first harmonic of its azimuthal lobes. `tests/test_mitsuba.py` compares with a path tracer.

Lobes are Chiang's whichever model draws the highlights. Where colours vary, tables are those of the mean absorption; a
vertex scales them with the colour of a mass of its own over that of the mean.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from . import chiang
from .kernels import dual as kernel
from .kernels.chiang import REST, TRT, TT, R
from .pigment import absorption_of, mass_colour, tint, varies

if TYPE_CHECKING:
    from ..scene.model import Material

N_THETA, N_PHI = 64, 257
MOST = 0.999
"""Part of light that a strand may scatter: at 1 no light would ever be lost in a mass of them."""


@dataclass(frozen=True, slots=True)
class DualTables:
    """What the kernel reads, float32.

    rows: (n_θ, 21) over θ_l in [0, π/2] (channels named in the kernel's file); it is even.
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
    v = chiang.variances(material.beta_m)
    f, b = ahead.mean(-1), behind.mean(-1)
    v_f, v_b = (f @ v) / f.sum(1), (b @ v) / b.sum(1)

    a_b = behind.sum(1)
    lost = np.maximum(1.0 - ahead.sum(1) - a_b, 1.0 - MOST)
    turned = np.einsum("j,ijpc->ic", weights * (1.0 - phi / np.pi), n)
    k1, c1 = lost + a_b, kernel.BROAD * turned
    c2, k2 = a_b, kernel.BROAD * (lost + turned)
    middle, reach = 0.5 * (k2 - k1), np.sqrt(0.25 * (k1 + k2) ** 2 - c1 * c2)
    mirror = c2 / (k2 - middle + reach)

    every = ahead + behind
    cosine = np.einsum("j,ijpc->ic", weights * np.cos(phi), n)
    rows = np.zeros((N_THETA, kernel.CHANNELS), np.float32)
    rows[:, kernel.FALL : kernel.FALL + 3] = reach - middle
    rows[:, kernel.GAP : kernel.GAP + 3] = 2.0 * reach
    rows[:, kernel.MIRROR : kernel.MIRROR + 3] = mirror
    rows[:, kernel.RATIO : kernel.RATIO + 3] = mirror * c1 / (k1 + middle + reach)
    rows[:, kernel.ROUND : kernel.ROUND + 3] = every.sum(1) / (2.0 * np.pi)
    rows[:, kernel.COSINE : kernel.COSINE + 3] = cosine * 2.0 / np.pi**2
    rows[:, kernel.SPREAD] = v_f
    rows[:, kernel.WIDTH] = 2.0 * v_f + v_b
    rows[:, kernel.OWN] = (every.mean(-1) @ v) / every.mean(-1).sum(1)
    return DualTables(rows, (1.0 / np.maximum(mass_colour(sigma, roughness), 1e-3)).astype(np.float32))
