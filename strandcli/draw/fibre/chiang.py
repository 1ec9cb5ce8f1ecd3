"""Tables of the hair model of Chiang, Bitterli, Tappan & Burley (2016, "A Practical and Controllable Hair and Fur
Model for Production Path Tracing"), averaged over the width of a strand; built once per material.

docs/fibres.md has the formulas of N_p, of the logistic D and of the variances of M, which the kernel evaluates. F is
Fresnel's reflectance at cos θ_v cos γ_i, T = exp(−2 σ_a cos γ_t / cos θ_t). Codes in use have the opposite sign of
``tilt``, for a tangent that points to the root.

Energy: rows of the table are scaled so that Σ_p ∫ N_p dφ of what is interpolated is Σ_p ½ ∫ A_p dh, which is 1 without
absorption.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .kernels import chiang as kernel
from .kernels import lobes
from .marschner import leaving, rays_across, seen
from .pigment import absorption_of, varies
from .tables import GAMMA, STEP, THETA, FibreTables, add_paths, mean_paths, table_of

if TYPE_CHECKING:
    from ...scene.model import Material

LEAST_VARIANCE = 1e-7
LEAST_SCALE = 1e-3
LARGEST_SCALE = 50.0
COEFFICIENT_FLOOR = 1e-6
MOST_COEFFICIENTS = 2048
RAYS = 12.0
"""Rays over half of the strand, times the logistic's scale."""


def variances(beta_m: float) -> NDArray[np.float64]:
    """(4,) v of the lobes R, TT, TRT and the rest."""
    v = (0.726 * beta_m + 0.812 * beta_m**2 + 3.7 * beta_m**20) ** 2
    return np.maximum(v * np.array([1.0, 0.25, 4.0, 4.0]), LEAST_VARIANCE)


def logistic_scale(beta_n: float) -> float:
    """s of the azimuthal logistic, radians."""
    s = math.sqrt(math.pi / 8.0) * (0.265 * beta_n + 1.194 * beta_n**2 + 5.372 * beta_n**22)
    return min(max(s, LEAST_SCALE), LARGEST_SCALE)


def tilts(tilt: float) -> NDArray[np.float64]:
    """(4,) radians added to θ_v before M: a lobe's peak is at θ_l = −(θ_v + that)."""
    return np.radians(tilt) * np.array([2.0, -1.0, -4.0, 0.0])


def build_tables(material: Material, n_theta: int = 64, n_phi: int | None = None) -> FibreTables | None:
    """Tables for ``material``, or None where ``material.specular`` is 0 and nothing would read them.

    By default n_φ gives three nodes to the logistic's scale, between 64 and 512 in all: 3 MB where β_n is under .1, and
    .4 MB at .3.
    """
    if material.specular == 0.0:
        return None
    s = logistic_scale(material.beta_n)
    if n_phi is None:
        n_phi = min(max(math.ceil(3.0 * math.pi / s) + 1, 64), 512)
    sigma = absorption_of(material, material.beta_n)
    # The last node lies on the horizon, where η' is infinite: it is taken a hair's breadth inside.
    theta = np.minimum(np.linspace(0.0, 0.5 * np.pi, n_theta), 0.5 * np.pi - 1e-4)
    nodes, paths = azimuthal(theta, n_phi, material.eta, sigma, s)
    shape = np.zeros(kernel.LOBES_SIZE, np.float32)
    sharp = 1.0 / variances(material.beta_m)
    shape[kernel.SHARP : kernel.SHARP + 4] = sharp
    shape[kernel.NORM : kernel.NORM + 4] = material.specular * sharp / -np.expm1(-2.0 * sharp)
    shape[kernel.COS : kernel.COS + 4] = np.cos(tilts(material.tilt))
    shape[kernel.SIN : kernel.SIN + 4] = np.sin(tilts(material.tilt))
    shape[kernel.THETA_SCALE], shape[kernel.THETA_LAST] = (n_theta - 1) / (0.5 * math.pi), (n_theta - 1) * (1.0 - 1e-6)
    shape[kernel.PHI_SCALE], shape[kernel.PHI_LAST] = (n_phi - 1) / math.pi, (n_phi - 1) * (1.0 - 1e-6)
    return FibreTables(kernel.ChiangArrays, shape, nodes, paths if varies(material) else None, sigma)


def columns(material: Material) -> NDArray[np.float32] | None:
    """Tables over the width, as `tables.table_of` makes them; None without highlights."""
    if material.specular == 0:
        return None
    sigma = absorption_of(material, material.beta_n)
    rays, _, out = passages(THETA, GAMMA, material.eta, sigma)
    s = max(logistic_scale(material.beta_n), 0.5 * STEP)
    return table_of(rays, out, functools.partial(_logistic, s=s), np.ones(7))


def _logistic(angle: NDArray[np.float64], s: float) -> NDArray[np.float64]:
    fall = np.exp(-np.abs(angle) / s)
    return np.asarray(fall / (s * (1.0 + fall) ** 2) / math.tanh(0.5 * np.pi / s))


def detector(s: float) -> NDArray[np.float64]:
    """∫ D(φ) cos kφ dφ, k = 0, 1, … until nothing is left, of the trimmed logistic of scale ``s``."""
    count = MOST_COEFFICIENTS * 8
    phi = (np.arange(count) + 0.5) * (np.pi / count)
    fall = np.exp(-phi / s)
    density = fall / (1.0 + fall) ** 2
    full = np.concatenate([density[::-1], density])
    series = np.fft.rfft(full)[:MOST_COEFFICIENTS]
    k = np.arange(MOST_COEFFICIENTS)
    # the samples begin half a step after −π: turn each coefficient back to the middle
    turned = (series * np.exp(1j * np.pi * k * (1.0 - 0.5 / count))).real / full.sum()
    significant = np.nonzero(np.abs(turned) > COEFFICIENT_FLOOR)[0]
    return np.asarray(turned[: significant[-1] + 1])


def azimuthal(
    theta: NDArray[np.float64], n_phi: int, eta: float, sigma: NDArray[np.float64], s: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """N, (n_θ, n_φ, 12), and mean paths, (n_θ, n_φ, 4): rays binned and blurred as for the Marschner tables."""
    gamma_i, weight = rays_across(max(256, math.ceil(RAYS / s)))
    rays, length, out = passages(theta, gamma_i, eta, sigma)
    rest = rays[:, 7:]
    rays = add_paths(rays, length)
    response = detector(s)
    bins = 2 ** math.ceil(math.log2(8 * len(response)))
    n = seen(rays * weight, out[:, [0, 1, 1, 1, 2, 2, 2, 1, 2]], n_phi, bins, response)
    ends = np.full(n_phi, np.pi / (n_phi - 1))
    ends[[0, -1]] *= 0.5
    found = 2.0 * np.einsum("j,ijc->ic", ends, n)
    n *= ((rays @ weight) / np.maximum(found, 1e-300))[:, None]

    nodes = np.zeros((len(theta), n_phi, kernel.NODE_SIZE), np.float32)
    nodes[..., : lobes.REST] = n[..., :7]
    nodes[..., lobes.REST : lobes.REST + 3] = (rest @ weight)[:, None] / (2.0 * np.pi)

    paths = np.zeros((len(theta), n_phi, 4), np.float32)
    paths[..., : lobes.PATH_REST] = mean_paths(n, theta, eta)
    # of p = 3, 4, … passes with weights falling as (F T)^p, 3 + F T / (1 − F T) is the mean number
    inner = (rays[:, :1] * np.exp(-length[:, None] * sigma[:, None])).mean(1)
    passes = rest.mean(1) * (3.0 + inner / (1.0 - inner)) * length
    paths[..., lobes.PATH_REST] = ((passes @ weight) / np.maximum(rest.mean(1) @ weight, 1e-300))[:, None]
    return nodes, paths / np.float32(math.log(2.0))


def passages(
    theta: NDArray[np.float64], gamma_i: NDArray[np.float64], eta: float, sigma: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Rays that enter a strand at the angles γ_i (n,), seen at θ_v (n_θ,): what is left of R, TT rgb, TRT rgb and the
    rest rgb, (n_θ, 10, n); chords inside in radii, (n_θ, n); the angles Φ of the first three, (n_θ, 3, n)."""
    cos_v, sin_v = np.cos(theta)[:, None], np.sin(theta)[:, None]
    root = np.sqrt(eta**2 - sin_v**2)
    gamma_t = np.arcsin(np.sin(gamma_i) * cos_v / root)
    f = _fresnel(cos_v * np.cos(gamma_i), eta)[:, None]
    length = 2.0 * np.cos(gamma_t) * eta / root
    through = np.exp(-length[:, None] * sigma[:, None])
    tt = (1.0 - f) ** 2 * through
    trt = tt * f * through
    rest = trt * f * through / (1.0 - f * through)
    return np.concatenate([f, tt, trt, rest], 1), length, leaving(gamma_i, gamma_t)


def _fresnel(cos_i: NDArray[np.float64], eta: float) -> NDArray[np.float64]:
    """Reflectance of a dielectric for unpolarised light."""
    cos_t = np.sqrt(1.0 - (1.0 - cos_i**2) / eta**2)
    parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    across = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    return np.asarray(0.5 * (parallel**2 + across**2))
