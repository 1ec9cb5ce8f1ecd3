"""The Marschner hair model in float64 without tables: what the renderer's tables and kernel are measured against.

`azimuthal` integrates N_p(θ_d, φ) over the offset h against the wrapped Gaussian, as the tables mean to; a traced ray
confirms its exit angles and chords. Nothing here is shared with `strandcli.draw`.

Angles are in radians and as in `strandcli/draw/fibre/kernels/marschner.py`; lobes are 0 (R), 1 (TT), 2 (TRT).
Absorption σ_a is one number in 1/radius: call once a channel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Fibre:
    """A strand's optics; angles in radians."""

    eta: float
    alpha: float
    beta: float
    azimuthal: float
    sigma: float


def indices(eta: float, theta_d: float) -> tuple[float, float]:
    """Bravais' η' and η'' of the cross section, for light at ``theta_d``."""
    root = math.sqrt(eta**2 - math.sin(theta_d) ** 2)
    return root / math.cos(theta_d), eta**2 * math.cos(theta_d) / root


def fresnel(eta: float, theta_d: float, gamma_i: Array) -> Array:
    """Reflectance for unpolarised light at the angle ``gamma_i`` in the cross section: η' for the component across the
    plane of incidence, η'' for the one within it; both refract by η'."""
    across, within = indices(eta, theta_d)
    cos_i = np.cos(gamma_i)
    cos_t = np.sqrt(1.0 - (np.sin(gamma_i) / across) ** 2)
    r_across = (cos_i - across * cos_t) / (cos_i + across * cos_t)
    r_within = (within * cos_i - cos_t) / (within * cos_i + cos_t)
    return 0.5 * (r_across**2 + r_within**2)


def exit_angle(lobe: int, eta: float, theta_d: float, gamma_i: Array) -> Array:
    """Φ_p, unwrapped: where a ray that enters at ``gamma_i`` leaves, relative to where it came from."""
    gamma_t = np.arcsin(np.sin(gamma_i) / indices(eta, theta_d)[0])
    return 2.0 * lobe * gamma_t - 2.0 * gamma_i + lobe * np.pi


def attenuation(lobe: int, fibre: Fibre, theta_d: float, gamma_i: Array) -> Array:
    """A_p: what Fresnel's reflectance and absorption along p chords leave of a ray."""
    f = fresnel(fibre.eta, theta_d, gamma_i)
    if lobe == 0:
        return f
    gamma_t = np.arcsin(np.sin(gamma_i) / indices(fibre.eta, theta_d)[0])
    theta_t = math.asin(math.sin(theta_d) / fibre.eta)
    chord = 2.0 * np.cos(gamma_t) / math.cos(theta_t)
    return (1.0 - f) ** 2 * f ** (lobe - 1) * np.exp(-lobe * fibre.sigma * chord)


def wrapped_gaussian(angle: Array, deviation: float) -> Array:
    """A Gaussian wound round the circle, summed turn by turn; its integral over any 2π is 1."""
    nearest = angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))
    turns = 2.0 * np.pi * np.arange(-3, 4) if deviation > 0.5 else np.zeros(1)  # beyond half a turn: e^-20 at most
    bells = [np.exp(-0.5 * ((nearest + turn) / deviation) ** 2) for turn in turns]
    return np.sum(bells, axis=0) / (math.sqrt(2.0 * math.pi) * deviation)


def quadrature(panels: int) -> tuple[Array, Array]:
    """Nodes γ_i and weights of ½ ∫ dh over h = sin γ_i in [−1, 1]: 16-point Gauss-Legendre on equal panels in γ_i."""
    x, weights = np.polynomial.legendre.leggauss(16)
    half = 0.5 * np.pi / panels
    middle = (np.arange(panels) + 0.5) * 2.0 * half - 0.5 * np.pi
    gamma = (middle[:, None] + half * x).ravel()
    return gamma, 0.5 * np.cos(gamma) * np.tile(half * weights, panels)


def azimuthal(lobe: int, fibre: Fibre, theta_d: float, phi: ArrayLike, panels: int = 64) -> Array:
    """N_p at one ``theta_d`` and each ``phi``; Φ turns by at most 2π / panels in a panel, which should be no more than
    some ten standard deviations: 64 panels do down to 1°."""
    gamma, weights = quadrature(panels)
    out = exit_angle(lobe, fibre.eta, theta_d, gamma)
    bell = wrapped_gaussian(np.asarray(phi, np.float64)[..., None] - out, fibre.azimuthal)
    return np.asarray(bell @ (weights * attenuation(lobe, fibre, theta_d, gamma)))


def longitudinal(lobe: int, fibre: Fibre, theta_h: ArrayLike) -> Array:
    """M_p = g(θ_h − α_p; β_p) / 2, whose integral over θ_v at a fixed θ_l is 1."""
    shift = (1.0, -0.5, -1.5)[lobe] * fibre.alpha
    width = (1.0, 0.5, 2.0)[lobe] * fibre.beta
    d = (np.asarray(theta_h, np.float64) - shift) / width
    return np.asarray(0.5 * np.exp(-0.5 * d * d) / (math.sqrt(2.0 * math.pi) * width))


def scattering(
    fibre: Fibre, theta_l: float, theta_v: float, phi: ArrayLike, lobes: tuple[int, ...] = (0, 1, 2)
) -> Array:
    """S cos θ_l, the kernel's result, at one pair of inclinations and each ``phi``."""
    theta_h, theta_d = 0.5 * (theta_v + theta_l), 0.5 * (theta_v - theta_l)
    total = sum(longitudinal(p, fibre, theta_h) * azimuthal(p, fibre, theta_d, phi) for p in lobes)
    return np.asarray(total * math.cos(theta_l) / math.cos(theta_d) ** 2)


def albedo(fibre: Fibre, theta_l: float, lobes: tuple[int, ...] = (0, 1, 2), steps: int = 2000) -> float:
    """Part of the light from ``theta_l`` that leaves: ∫ S cos θ_v dω_v, by the midpoint rule over θ_v.

    N_p integrates over φ to ½ ∫ A_p dh, D being normalised, so that only θ_v is left.
    """
    theta_v = (np.arange(steps) + 0.5) * (np.pi / steps) - 0.5 * np.pi
    theta_h, theta_d = 0.5 * (theta_v + theta_l), 0.5 * (theta_v - theta_l)
    gamma, weights = quadrature(8)
    total = np.zeros(steps)
    for p in lobes:
        part = [weights @ attenuation(p, fibre, d, gamma) for d in theta_d]
        total += longitudinal(p, fibre, theta_h) * np.array(part)
    return float(np.sum(total * np.cos(theta_v) ** 2 / np.cos(theta_d) ** 2) * (np.pi / steps))
