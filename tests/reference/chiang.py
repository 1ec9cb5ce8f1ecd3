"""Chiang's hair model in float64 without tables, offset by offset: what the renderer's tables and kernel are measured
against. Nothing here is shared with `strandcli.draw`.

Angles are in radians and as in `strandcli/draw/fibre/kernels/marschner.py`; the tangent runs from root to tip.
Absorption σ_a is one number in 1/radius.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
LOBES = 4


@dataclass(frozen=True, slots=True)
class Hair:
    """A strand's optics; ``tilt`` in degrees, as in a preset."""

    beta_m: float
    beta_n: float
    tilt: float
    sigma: float
    eta: float = 1.55


@cache
def gauss(count: int) -> tuple[Array, Array]:
    """Nodes in [−1, 1] and weights of Gauss and Legendre's rule, found once."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights


def scaled_bessel(x: ArrayLike) -> Array:
    """e^-x I₀(x) = 1/π ∫_0^π e^(x (cos t − 1)) dt, by Gauss-Legendre over the part of [0, π] that counts."""
    x = np.asarray(x, np.float64)[..., None]
    nodes, weights = gauss(96)
    end = np.minimum(np.pi, 9.0 / np.sqrt(np.maximum(x, 1e-12)))
    t = 0.5 * end * (nodes + 1.0)
    return np.asarray((np.exp(-2.0 * x * np.sin(0.5 * t) ** 2) * weights).sum(-1) * 0.5 * end[..., 0] / np.pi)


def longitudinal(lobe: int, hair: Hair, theta_l: ArrayLike, theta_v: float) -> Array:
    """d'Eon's M_p."""
    v = (0.726 * hair.beta_m + 0.812 * hair.beta_m**2 + 3.7 * hair.beta_m**20) ** 2 * (1.0, 0.25, 4.0, 4.0)[lobe]
    turned = theta_v + math.radians(hair.tilt) * (2.0, -1.0, -4.0, 0.0)[lobe]
    theta_l = np.asarray(theta_l, np.float64)
    cosines = np.cos(theta_l) * abs(math.cos(turned)) / v
    exponent = cosines - np.sin(theta_l) * math.sin(turned) / v - 1.0 / v
    return np.asarray(scaled_bessel(cosines) * np.exp(exponent) / (v * -math.expm1(-2.0 / v)))


def attenuations(hair: Hair, theta_v: float, h: ArrayLike) -> Array:
    """(4, …) A_p at the offsets ``h``."""
    sin_i = np.asarray(h, np.float64)
    cos_v = math.cos(theta_v)
    cos_t = math.sqrt(1.0 - (math.sin(theta_v) / hair.eta) ** 2)
    prime = math.sqrt(hair.eta**2 - math.sin(theta_v) ** 2) / cos_v
    incident = cos_v * np.sqrt(1.0 - sin_i**2)
    inside = np.sqrt(1.0 - (1.0 - incident**2) / hair.eta**2)
    parallel = (hair.eta * incident - inside) / (hair.eta * incident + inside)
    across = (incident - hair.eta * inside) / (incident + hair.eta * inside)
    f = 0.5 * (parallel**2 + across**2)
    t = np.exp(-2.0 * hair.sigma * np.sqrt(1.0 - (sin_i / prime) ** 2) / cos_t)
    return np.stack([f, (1 - f) ** 2 * t, (1 - f) ** 2 * t**2 * f, (1 - f) ** 2 * t**3 * f**2 / (1 - t * f)])


def azimuthal(lobe: int, hair: Hair, theta_v: float, phi: ArrayLike, h: ArrayLike) -> Array:
    """D(φ − Φ_p(h)), or 1/2π for the rest; ``phi`` and ``h`` broadcast."""
    phi, h = np.broadcast_arrays(np.asarray(phi, np.float64), np.asarray(h, np.float64))
    if lobe == 3:
        return np.full(phi.shape, 0.5 / np.pi)
    s = math.sqrt(math.pi / 8.0) * (0.265 * hair.beta_n + 1.194 * hair.beta_n**2 + 5.372 * hair.beta_n**22)
    prime = math.sqrt(hair.eta**2 - math.sin(theta_v) ** 2) / math.cos(theta_v)
    out = 2.0 * lobe * np.arcsin(h / prime) - 2.0 * np.arcsin(h) + lobe * np.pi
    apart = phi - out
    apart = np.abs(apart - 2.0 * np.pi * np.round(apart / (2.0 * np.pi)))
    fall = np.exp(-apart / s)
    whole = math.tanh(0.5 * math.pi / s)  # what lies in [−π, π]
    return np.asarray(fall / (s * (1.0 + fall) ** 2) / whole)


def at_offset(hair: Hair, theta_l: float, theta_v: float, phi: float, h: ArrayLike) -> Array:
    """Σ_p M_p A_p D_p, the cosine at the light inside, for rays at the offsets ``h``."""
    a = attenuations(hair, theta_v, h)
    parts = [longitudinal(p, hair, theta_l, theta_v) * a[p] * azimuthal(p, hair, theta_v, phi, h) for p in range(LOBES)]
    return np.asarray(np.sum(parts, axis=0))


def offsets(panels: int = 48) -> tuple[Array, Array]:
    """h and weights of ½ ∫ dh over [−1, 1]: 16-point Gauss-Legendre on equal panels of asin h."""
    nodes, weights = gauss(16)
    half = 0.5 * np.pi / panels
    middle = (np.arange(panels) + 0.5) * 2.0 * half - 0.5 * np.pi
    gamma = (middle[:, None] + half * nodes).ravel()
    return np.sin(gamma), 0.5 * np.cos(gamma) * np.tile(half * weights, panels)


def profile(lobe: int, hair: Hair, theta_v: float, phi: ArrayLike) -> Array:
    """N_p at each ``phi``."""
    h, weights = offsets()
    phi = np.asarray(phi, np.float64)
    bells = azimuthal(lobe, hair, theta_v, phi[..., None], h)
    return np.asarray(bells @ (weights * attenuations(hair, theta_v, h)[lobe]))


def scattering(hair: Hair, theta_l: float, theta_v: float, phi: ArrayLike) -> Array:
    """S cos θ_l, the kernel's result, at one pair of inclinations and each ``phi``."""
    parts = [longitudinal(p, hair, theta_l, theta_v) * profile(p, hair, theta_v, phi) for p in range(LOBES)]
    return np.asarray(np.sum(parts, axis=0))
