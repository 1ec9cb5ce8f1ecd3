"""Tables of the Marschner hair model (Marschner, Jensen, Cammarano, Worley & Hanrahan 2003), built once per material.

S = Σ_p M_p(θ_h) N_p(θ_d, φ) / cos² θ_d over the lobes p = 0 (R), 1 (TT), 2 (TRT); angles as in `kernels/marschner.py`.

Longitudinal: M_p = g(θ_h − α_p; β_p) / 2, g the normalised Gaussian, with α_p = α, −α/2, −3α/2 and β_p = β, β/2, 2β.
The half turns dθ_v = 2 dθ_h into ∫ M_p dθ_v = 1, so that at small β a strand returns what N_p returns. A negative α
leans R toward the root. M is evaluated in the kernel: three short polynomials are exact for every β, where a table of
equal error would take 6,000 nodes at β = .1°.

Azimuthal: N_p(θ_d, φ) = ½ ∫_{-1}^{1} A_p(h) D(φ − Φ_p(h)) dh with Φ_p = 2pγ_t − 2γ_i + pπ, h = sin γ_i = η' sin γ_t,
the indices η' and η'' of the cross section (Bravais), A_0 = F, A_p = (1 − F)² F^{p−1} T^p. D is the wrapped Gaussian
whose standard deviation is the material's azimuthal roughness, the same for every lobe; it takes the place of the
paper's caustic removal. As D's Fourier coefficients are exp(−k² s² / 2), the integral over h is done for each of them.

Absorption: T = exp(−2 σ_a cos γ_t / cos θ_t), 2 cos γ_t being the chord of the unit circle. The paper prints
exp(−2 σ_a (1 + cos 2γ_t)), whose length 4 cos² γ_t is twice the diameter for h = 0; the chord is what Chiang et al.'s
colours were fitted with, and a traced ray confirms it (tests/test_study_bsdf.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .kernels import marschner as kernel

if TYPE_CHECKING:
    from ..scene.model import Material

DARKEST, PALEST = 1e-4, 1.0
COS2_FLOOR = 1e-3
COEFFICIENT_FLOOR = 1e-9
PATH_FLOOR = 1e-6


@dataclass(frozen=True, slots=True)
class MarschnerTables:
    """What the kernel reads. All float32 and C order; θ_d and φ are even in angle over [0, π/2] and [0, π].

    lobes: (11,) shifts, widths, index scales (places named in the kernel's file).
    nodes: (n_θ, n_φ, 8) R, TT rgb, TRT rgb, 0 - N_p times the peak of M_p times material.specular.
    paths: (n_θ, n_φ, 2) log₂ e times the mean path length in TT and TRT, in radii, or None where no colour varies.
    absorption: (3,) float64, σ_a of the material's colour, in 1/radius.
    roughness: Chiang's β_n that stands for the azimuthal roughness, for `absorption`.
    """

    lobes: NDArray[np.float32]
    nodes: NDArray[np.float32]
    paths: NDArray[np.float32] | None
    absorption: NDArray[np.float64]
    roughness: float

    @property
    def nbytes(self) -> int:
        return self.lobes.nbytes + self.nodes.nbytes + (0 if self.paths is None else self.paths.nbytes)


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


def absorption(colour: ArrayLike, roughness: float) -> NDArray[np.float64]:
    """σ_a in 1/radius of strands whose mass has this ``colour`` (any shape, linear), by Chiang et al. 2016, eq. 9.

    Colours are clamped to [1e-4, 1]: black would be infinitely absorbing, and nothing is whiter than σ_a = 0.
    """
    b = roughness
    divisor = 5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5
    return np.asarray((np.log(np.clip(np.asarray(colour, np.float64), DARKEST, PALEST)) / divisor) ** 2)


def build_tables(material: Material, n_theta: int = 48, n_phi: int | None = None) -> MarschnerTables | None:
    """Tables for ``material``, or None where ``material.specular`` is 0 and nothing would read them.

    By default n_φ gives four nodes to a standard deviation of the azimuthal roughness, between 48 and 192 in all: the
    roughness is resolved down to 3.75°, and `nodes` stays under 300 kB.
    """
    if material.specular == 0.0:
        return None
    if n_phi is None:
        n_phi = min(max(math.ceil(4.0 * 180.0 / material.azimuthal) + 1, 48), 192)
    roughness = azimuthal_beta(material.azimuthal)
    sigma = absorption(material.colour, roughness)
    # The last node lies on the horizon, where η' is infinite: it is taken a hair's breadth inside.
    theta = np.minimum(np.linspace(0.0, 0.5 * np.pi, n_theta), 0.5 * np.pi - 1e-4)
    lobes, peaks = _longitudinal(material, n_theta, n_phi)
    n, paths = _azimuthal(theta, n_phi, material.eta, sigma, math.radians(material.azimuthal))
    nodes = np.zeros((n_theta, n_phi, kernel.NODE_SIZE), np.float32)
    nodes[..., kernel.R] = n[0, ..., 0] * peaks[0]
    nodes[..., kernel.TT : kernel.TT + 3] = n[1] * peaks[1]
    nodes[..., kernel.TRT : kernel.TRT + 3] = n[2] * peaks[2]
    varied = material.tip_colour is not None or material.colour_variation > 0.0
    return MarschnerTables(lobes, nodes, paths if varied else None, sigma, roughness)


def _longitudinal(material: Material, n_theta: int, n_phi: int) -> tuple[NDArray[np.float32], list[float]]:
    """The array `lobes`, in terms of 2θ_h, and the three peaks of M_p times material.specular."""
    alpha, beta = math.radians(material.alpha), math.radians(material.beta)
    widths = (beta, 0.5 * beta, 2.0 * beta)
    lobes = np.zeros(kernel.LOBES_SIZE, np.float32)
    lobes[kernel.SHIFT_R : kernel.SHIFT_R + 3] = [2.0 * alpha, -alpha, -3.0 * alpha]
    lobes[kernel.FALL_R : kernel.FALL_R + 3] = [-0.125 / (w * w * math.log(2.0)) for w in widths]
    lobes[kernel.THETA_SCALE], lobes[kernel.THETA_LAST] = (n_theta - 1) / math.pi, (n_theta - 1) * (1.0 - 1e-6)
    lobes[kernel.PHI_SCALE], lobes[kernel.PHI_LAST] = (n_phi - 1) / math.pi, (n_phi - 1) * (1.0 - 1e-6)
    # 1/cos² θ_d of a perfectly sharp lobe has no bound; a lobe β wide cannot tell 90° from 90° − β.
    lobes[kernel.COS2_FLOOR] = 2.0 * max(COS2_FLOOR, math.sin(beta) ** 2)
    return lobes, [0.5 * material.specular / (math.sqrt(2.0 * math.pi) * w) for w in widths]


def _azimuthal(
    theta: NDArray[np.float64], n_phi: int, eta: float, sigma: NDArray[np.float64], deviation: float
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """N_p, (3, n_θ, n_φ, 3), and the mean paths, (n_θ, n_φ, 2), by a Fourier series in φ whose coefficients are
    integrals over h.

    Both signs of h give the same cosine coefficients, so half of the range is enough. With γ_i = π/2 sin u the midpoint
    rule in u converges with the fourth power of the number of nodes, the integrand and its slope being 0 at h = 1.
    """
    order = math.ceil(math.sqrt(-2.0 * math.log(COEFFICIENT_FLOOR)) / deviation)
    count = max(128, 2 * order)
    u = (np.arange(count) + 0.5) * (0.5 * np.pi / count)
    gamma_i = 0.5 * np.pi * np.sin(u)
    weight = np.cos(gamma_i) * np.cos(u) * (0.5 * np.pi) ** 2 / count

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

    # Four columns a lobe: rgb, and the path length weighted with the mean of rgb.
    columns = np.zeros((len(theta), 3, 4, count))
    columns[:, 0, :3] = fresnel[:, None]
    columns[:, 1, :3] = ((1.0 - fresnel) ** 2)[:, None] * through
    columns[:, 2, :3] = ((1.0 - fresnel) ** 2 * fresnel)[:, None] * through**2
    columns[:, 1, 3] = columns[:, 1, :3].mean(axis=1) * length
    columns[:, 2, 3] = columns[:, 2, :3].mean(axis=1) * length * 2.0
    columns *= weight

    # cos((ab + c)Φ) = cos abΦ cos cΦ − sin abΦ sin cΦ: two small matrix products in place of every cosine.
    block = math.isqrt(order) + 1
    coarse, fine = block * np.arange(block)[:, None], np.arange(block)
    coefficients = np.empty((len(theta), 3, 4, block * block))
    for row in range(len(theta)):
        angle = np.stack([-2.0 * gamma_i, 2.0 * (gamma_t[row] - gamma_i) + np.pi, 4.0 * gamma_t[row] - 2.0 * gamma_i])
        large, small = angle[:, None, None] * coarse, angle[:, :, None] * fine
        weighted = columns[row][:, :, None]
        product = (np.cos(large) * weighted).reshape(3, -1, count) @ np.cos(small)
        product -= (np.sin(large) * weighted).reshape(3, -1, count) @ np.sin(small)
        coefficients[row] = product.reshape(3, 4, -1)
    k = np.arange(block * block)
    damping = np.exp(-0.5 * (k * deviation) ** 2) * np.where(k == 0, 1.0, 2.0) / (2.0 * np.pi)
    # A chord lies below a hump by d²/12 of its curvature on average: nodes raised by that make the interpolant right in
    # the mean, and its RMS error 2.4 times smaller.
    damping *= 1.0 + (k * np.pi / (n_phi - 1)) ** 2 / 12.0
    series = np.cos(np.linspace(0.0, np.pi, n_phi)[:, None] * k) * damping
    n = np.maximum(np.moveaxis(coefficients @ series.T, (1, 2), (0, 3)), 0.0)

    mean = n[1:, ..., :3].mean(axis=-1)
    known = mean > PATH_FLOOR * mean.max(axis=(1, 2), keepdims=True)
    plain = np.array([1.0, 2.0])[:, None, None] * (2.0 * eta / root)
    paths = np.where(known, n[1:, ..., 3] / np.where(known, mean, 1.0), plain)
    paths = np.clip(paths, 0.0, plain) / math.log(2.0)
    return n[..., :3], np.ascontiguousarray(np.moveaxis(paths, 0, -1), np.float32)
