"""Tables of the Marschner hair model (Marschner, Jensen, Cammarano, Worley & Hanrahan 2003), built once per material.

S = Σ_p M_p(θ_h) N_p(θ_d, φ) / cos² θ_d over the lobes p = 0 (R), 1 (TT), 2 (TRT); angles as in `kernels/marschner.py`.

docs/fibres.md has the formulas of M_p and N_p. M is evaluated in the kernel, within 2e-4 down to β = .1°; there a table
within .5 % would take 18,000 nodes, as TT is half as wide (d² / 8σ² of linear interpolation).

Energy: ∫ S cos θ_v dω_v with no absorption is .97 at α = 0 and normal incidence. Off the mirror direction cos² θ_v is
not cos² θ_d, so the form is symmetric but not conserving: up to 1.11 at α = −7.5° and θ_l = 60°.

Accuracy of the default size at 12° up to θ_d = 80°, against quadrature: RMS R .22 %, TT .03 %, TRT .18 %; pointwise
above a tenth of a lobe's peak .4, .2 and 1 %.

Absorption: T = exp(−2 σ_a cos γ_t / cos θ_t), 2 cos γ_t being the chord of the unit circle. The paper prints
exp(−2 σ_a (1 + cos 2γ_t)), whose length 4 cos² γ_t is twice the diameter for h = 0; the chord is what Chiang et al.'s
colours were fitted with, and a traced ray confirms it (tests/study/test_bsdf.py).
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .kernels import marschner as kernel
from .pigment import absorption_of, varies
from .tables import GAMMA, STEP, THETA, FibreTables, add_paths, mean_paths, table_of

if TYPE_CHECKING:
    from ...scene.model import Material

COS2_FLOOR = 1e-3
COEFFICIENT_FLOOR = 1e-7
RAYS = 8.0  # rays over half of the strand, times the roughness: no two leave farther apart than .62 of it
BINS = 200.0  # bins over the circle, times the roughness: what sharing leaves aliased is under 3e-5


def azimuthal_beta(degrees: float) -> float:
    """Chiang et al.'s β_n in [0, 1] whose trimmed logistic has the standard deviation ``degrees``; 12° gives .297.

    Their scale is s = √(π/8) (.265 β_n + 1.194 β_n² + 5.372 β_n²²) (2016, §4.1) and its standard deviation s π / √3.
    """
    wanted = math.radians(degrees) * math.sqrt(3.0) / math.pi / math.sqrt(math.pi / 8.0)
    low, high = 0.0, 1.0
    for _ in range(60):
        beta = 0.5 * (low + high)
        if 0.265 * beta + 1.194 * beta**2 + 5.372 * beta**22 < wanted:
            low = beta
        else:
            high = beta
    return 0.5 * (low + high)


def build_tables(material: Material, n_theta: int = 48, n_phi: int | None = None) -> FibreTables | None:
    """Tables for ``material``, or None where ``material.specular`` is 0 and nothing would read them.

    By default n_φ gives four nodes to a standard deviation of the azimuthal roughness, between 48 and 192 in all: the
    roughness is resolved down to 3.75°, and `nodes` stays under 300 kB.
    """
    if material.specular == 0.0:
        return None
    if n_phi is None:
        n_phi = min(max(math.ceil(4.0 * 180.0 / material.azimuthal) + 1, 48), 192)
    roughness = azimuthal_beta(material.azimuthal)
    sigma = absorption_of(material, roughness)
    # The last node lies on the horizon, where η' is infinite: it is taken a hair's breadth inside.
    theta = np.minimum(np.linspace(0.0, 0.5 * np.pi, n_theta), 0.5 * np.pi - 1e-4)
    lobes = _longitudinal(material, n_theta, n_phi)
    n, paths = _azimuthal(theta, n_phi, material.eta, sigma, math.radians(material.azimuthal))
    nodes = np.zeros((n_theta, n_phi, kernel.NODE_SIZE), np.float32)
    nodes[..., :7] = n * np.repeat(peaks(material), (1, 3, 3))
    return FibreTables(kernel.MarschnerArrays, lobes, nodes, paths if varies(material) else None, sigma)


def columns(material: Material) -> NDArray[np.float32] | None:
    """Tables over the width, as `tables.table_of` makes them; None without highlights."""
    if material.specular == 0:
        return None
    sigma = absorption_of(material, azimuthal_beta(material.azimuthal))
    rays, _, out = passages(THETA, GAMMA, material.eta, sigma)
    deviation = max(math.radians(material.azimuthal), 0.75 * STEP)
    scales = np.repeat(peaks(material), (1, 3, 3))
    return table_of(rays, out, functools.partial(_gaussian, deviation=deviation), scales)


def _gaussian(angle: NDArray[np.float64], deviation: float) -> NDArray[np.float64]:
    turns = [np.exp(-0.5 * ((angle + turn) / deviation) ** 2) for turn in (-2.0 * np.pi, 0.0, 2.0 * np.pi)]
    return np.asarray(sum(turns) / (math.sqrt(2.0 * np.pi) * deviation))


def _longitudinal(material: Material, n_theta: int, n_phi: int) -> NDArray[np.float32]:
    """The array `lobes`, in terms of 2θ_h."""
    alpha, beta = math.radians(material.alpha), math.radians(material.beta)
    widths = _widths(material)
    lobes = np.zeros(kernel.LOBES_SIZE, np.float32)
    lobes[kernel.SHIFT_R : kernel.SHIFT_R + 3] = [2.0 * alpha, -alpha, -3.0 * alpha]
    lobes[kernel.FALL_R : kernel.FALL_R + 3] = [-0.125 / (w * w * math.log(2.0)) for w in widths]
    lobes[kernel.THETA_SCALE], lobes[kernel.THETA_LAST] = (n_theta - 1) / math.pi, (n_theta - 1) * (1.0 - 1e-6)
    lobes[kernel.PHI_SCALE], lobes[kernel.PHI_LAST] = (n_phi - 1) / math.pi, (n_phi - 1) * (1.0 - 1e-6)
    # 1/cos² θ_d of a perfectly sharp lobe has no bound; a lobe β wide cannot tell 90° from 90° − β.
    lobes[kernel.COS2_FLOOR] = 2.0 * max(COS2_FLOOR, math.sin(beta) ** 2)
    return lobes


def _widths(material: Material) -> tuple[float, float, float]:
    beta = math.radians(material.beta)
    return beta, 0.5 * beta, 2.0 * beta


def peaks(material: Material) -> list[float]:
    """M at the middle of R, TT and TRT, times material.specular."""
    return [0.5 * material.specular / (math.sqrt(2.0 * math.pi) * width) for width in _widths(material)]


def _azimuthal(
    theta: NDArray[np.float64], n_phi: int, eta: float, sigma: NDArray[np.float64], deviation: float
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """N, (n_θ, n_φ, 7) for R, TT rgb and TRT rgb, and the mean paths, (n_θ, n_φ, 2).

    Rays spread over h are dropped by their Φ into bins round the circle, each shared by its two nearest bins; the bins'
    Fourier coefficients, cleared of that sharing and damped by the detector's, give N at the nodes. Only cosines are
    needed, for which both signs of h count alike: half of the rays is enough.
    """
    gamma_i, weight = rays_across(max(128, math.ceil(RAYS / deviation)))
    rays, length, out = passages(theta, gamma_i, eta, sigma)
    rays = add_paths(rays, length)
    bins = 2 ** math.ceil(math.log2(BINS / deviation))
    k = np.arange(math.ceil(math.sqrt(-2.0 * math.log(COEFFICIENT_FLOOR)) / deviation) + 1)
    detector = np.exp(-0.5 * (k * deviation) ** 2)
    n = seen(rays * weight, out[:, [0, 1, 1, 1, 2, 2, 2, 1, 2]], n_phi, bins, detector)
    return n[..., :7], (mean_paths(n, theta, eta) / math.log(2.0)).astype(np.float32)


def passages(
    theta: NDArray[np.float64], gamma_i: NDArray[np.float64], eta: float, sigma: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Rays that enter a strand at the angles γ_i (n,), light coming at θ_d (n_θ,): what is left of R, TT rgb and TRT
    rgb, (n_θ, 7, n); chords inside in radii, (n_θ, n); the angles Φ at which they leave, (n_θ, 3, n)."""
    cos_d, sin_d = np.cos(theta)[:, None], np.sin(theta)[:, None]
    root = np.sqrt(eta**2 - sin_d**2)
    index_s, index_p = root / cos_d, eta**2 * cos_d / root
    gamma_t = np.arcsin(np.sin(gamma_i) / index_s)
    cos_i, cos_t = np.cos(gamma_i), np.cos(gamma_t)
    s = (cos_i - index_s * cos_t) / (cos_i + index_s * cos_t)
    p = (index_p * cos_i - cos_t) / (index_p * cos_i + cos_t)
    fresnel = 0.5 * (s * s + p * p)
    length = 2.0 * cos_t * eta / root
    through = np.exp(-length[:, None, :] * sigma[:, None])
    rays = np.empty((len(theta), 7, len(gamma_i)))
    rays[:, 0] = fresnel
    rays[:, 1:4] = ((1.0 - fresnel) ** 2)[:, None] * through
    rays[:, 4:7] = ((1.0 - fresnel) ** 2 * fresnel)[:, None] * through**2
    return rays, length, leaving(gamma_i, gamma_t)


def leaving(gamma_i: NDArray[np.float64], gamma_t: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n_θ, 3, n): Φ of R, TT and TRT."""
    return np.stack(
        [-2.0 * gamma_i + 0.0 * gamma_t, 2.0 * (gamma_t - gamma_i) + np.pi, 4.0 * gamma_t - 2.0 * gamma_i], 1
    )


def rays_across(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """γ_i in (0, π/2) and the weights of ∫_0^1 dh. With γ_i = π/2 sin u the midpoint rule in u converges with the
    fourth power of ``count``: the integrand and its slope are 0 at h = 1."""
    u = (np.arange(count) + 0.5) * (0.5 * np.pi / count)
    gamma_i = 0.5 * np.pi * np.sin(u)
    return gamma_i, np.cos(gamma_i) * np.cos(u) * (0.5 * np.pi) ** 2 / count


def seen(
    rays: NDArray[np.float64], out: NDArray[np.float64], n_phi: int, bins: int, detector: NDArray[np.float64]
) -> NDArray[np.float64]:
    """What the detector sees at ``n_phi`` angles over [0, π], (n_θ, n_φ, channels), of rays (n_θ, channels, count) that
    leave at the angles ``out``. ``detector``: the Fourier coefficients ∫ D(φ) cos kφ dφ of its response, k = 0, 1, …;
    rays are gathered in so many ``bins``, which have to outnumber twice the coefficients."""
    rows, channels, _ = rays.shape
    place = out * (bins / (2.0 * np.pi))
    below = np.floor(place)
    part = place - below
    row = bins * np.arange(rows * channels).reshape(rows, channels, 1)
    below = below.astype(np.int64)
    index = np.concatenate([row + below % bins, row + (below + 1) % bins], axis=-1)
    share = np.concatenate([rays * (1.0 - part), rays * part], axis=-1)
    counts = np.bincount(index.ravel(), share.ravel(), rows * channels * bins).reshape(rows * channels, bins)

    k = np.arange(len(detector))
    scale = detector / np.sinc(k / bins) ** 2 * np.where(k == 0, 0.5, 1.0) / np.pi
    # A chord lies below a hump by d²/12 of its curvature on average: nodes raised by that make the interpolant right in
    # the mean, and its RMS error 2.4 times smaller.
    scale *= 1.0 + (k * np.pi / (n_phi - 1)) ** 2 / 12.0
    series = np.cos(k[:, None] * np.linspace(0.0, np.pi, n_phi)) * scale[:, None]
    n = (np.fft.rfft(counts)[:, : len(k)].real @ series).reshape(rows, channels, n_phi)
    return np.maximum(np.moveaxis(n, 1, 2), 0.0)
