"""Tables of dual scattering: light that reaches a strand through its neighbours, and what the strands about it send
back. Built once per material, over the inclination of the light.

docs/fibres.md has the model, three streams in closed form, and what its letters mean: after Zinke, Yuksel, Weber &
Keyser (2008), for strands that are met at random, τ of them on average before a point and τ' behind it. Tables hold κ,
R, k₀, P and Q; A and C follow from τ and τ'. D and U come at 45° on average, so that they meet √2 times the strands.

A strand answers to D and B − e^-τ as evenly spread over the half circle about the light, by the mean and the first
harmonic of its azimuthal lobes; B, which is narrower, has the second as well, weakened once more by the passage that
turned it. It answers to U from the half circle behind. `tests/study/test_mitsuba.py` compares with a path tracer.

Lobes are Chiang's whichever model draws the highlights. Where colours vary, tables are those of the mean absorption; a
vertex scales them with the colour of a mass of its own over that of the mean.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..common.kernels.batch import CHANNELS
from . import chiang
from .kernels import dual as kernel
from .kernels.lobes import REST, TRT, TT, R
from .pigment import absorption_of, mass_colour, tint, varies

if TYPE_CHECKING:
    from ...scene.model import Material

N_THETA, N_PHI = 64, 257
LOSS_NODES = 1025
"""Of the table of light that strands keep from what is behind them: so many that the nearest one is less than .001 of
the light off."""
MOST = 0.999
"""Part of light that a strand may scatter: at 1 no light would ever be lost in a mass of them."""
APART = 0.02
"""Least relative difference of k₀ and κ: where they are one, P and Q are infinite."""


def loss_table(tables: kernel.DualArrays) -> NDArray[np.float32]:
    """(`LOSS_NODES`, 4): the share of a light that τ strands keep from what is behind them, in even steps of
    τ / (τ + 2): 1 less `kernels.dual.through`. The last row is that of no end of strands; the last
    column makes rows of four numbers, which kernels fetch at once."""
    streams = streams_of(tables)
    table = np.ones((LOSS_NODES, 4), np.float32)
    for row, share in enumerate(np.linspace(0.0, 1.0, LOSS_NODES)[:-1]):
        passed = np.float32(float(kernel.HALF_WAY) * share / (1.0 - share))
        table[row, :3] = [1.0 - kernel.through(passed, streams, c) for c in range(3)]
    return np.clip(table, 0, 1)


def streams_of(tables: kernel.DualArrays) -> NDArray[np.float32]:
    """(5, 3): κ, R, k₀, P and Q of `kernels.dual.through`, for light on what is behind strands: the mean over strands
    that lie in all directions, by the area that they show."""
    theta = np.linspace(0.0, 0.5 * np.pi, N_THETA)
    weights = np.cos(theta) ** 2
    mean = weights @ tables.rows[:, : 5 * 3].astype(np.float64) / weights.sum()
    return mean.reshape(5, 3).astype(np.float32)


def build_tables(material: Material, roughness: float) -> kernel.DualArrays:
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

    cosine = np.einsum("j,ijpc->ic", weights * np.cos(phi), n)
    a_b = behind.sum(1)
    a = np.minimum(ahead.sum(1) + a_b, MOST)
    second = np.clip(np.einsum("j,ijpc->ic", weights * np.cos(2.0 * phi), n), 0.0, a - a_b)
    # φ = π is light that goes straight on
    c = kernel.SLANT * 0.5 * (a + cosine)
    k = kernel.SLANT * (1.0 - a) + c
    decay = np.sqrt(k**2 - c**2)
    beam = 1.0 - second
    beam = np.where(np.abs(beam / decay - 1.0) < APART, (1.0 + APART) * decay, beam)
    over = decay**2 - beam**2

    every = ahead + behind
    rows = np.zeros((N_THETA, CHANNELS), np.float32)
    rows[:, kernel.DECAY : kernel.DECAY + 3] = decay
    rows[:, kernel.MIRROR : kernel.MIRROR + 3] = c / (k + decay)
    rows[:, kernel.BEAM : kernel.BEAM + 3] = beam
    rows[:, kernel.ON : kernel.ON + 3] = ((a - a_b - second) * (k + beam) + c * a_b) / over
    rows[:, kernel.BACK : kernel.BACK + 3] = (a_b * (k - beam) + c * (a - a_b - second)) / over
    rows[:, kernel.ROUND : kernel.ROUND + 3] = every.sum(1) / (2.0 * np.pi)
    rows[:, kernel.COSINE : kernel.COSINE + 3] = cosine * 2.0 / np.pi**2
    rows[:, kernel.SPREAD] = v_f
    rows[:, kernel.WIDTH] = 2.0 * v_f + v_b
    rows[:, kernel.OWN] = (every.mean(-1) @ v) / every.mean(-1).sum(1)
    return kernel.DualArrays(rows, (1.0 / np.maximum(mass_colour(sigma, roughness), 1e-3)).astype(np.float32))
