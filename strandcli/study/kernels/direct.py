"""Marschner's model without tables: the integral over the offset h for every direction anew."""

from __future__ import annotations

import math

import numpy as np

from ...jit import function, parallel, prange

TURN = 2.0 * math.pi


@function
def bell(angle, deviation):
    """A Gaussian wound round the circle, by its three nearest turns."""
    a = angle - TURN * np.floor(angle / TURN + 0.5)
    total = 0.0
    for turn in range(-1, 2):
        d = (a + TURN * turn) / deviation
        total += math.exp(-0.5 * d * d)
    return total / (math.sqrt(TURN) * deviation)


@parallel
def scattering(theta_l, theta_v, phi, eta, alpha, beta, deviation, sigma, nodes, out):
    """S cos θ_l by the midpoint rule over ``nodes`` offsets h, even in their angle.

    theta_l, theta_v, phi (D,); alpha, beta, deviation in radians; sigma (3,) in 1/radius; out (D, 3). All float64.
    """
    for i in prange(theta_l.shape[0]):
        half = 0.5 * (theta_v[i] - theta_l[i])
        middle = 0.5 * (theta_v[i] + theta_l[i])
        cos_d = math.cos(half)
        root = math.sqrt(eta * eta - math.sin(half) ** 2)
        across = root / cos_d
        within = eta * eta * cos_d / root
        scale = math.cos(theta_l[i]) / (cos_d * cos_d)
        for c in range(3):
            out[i, c] = 0.0
        for k in range(nodes):
            gamma = ((k + 0.5) / nodes - 0.5) * math.pi
            weight = 0.5 * math.cos(gamma) * math.pi / nodes * scale
            inner = math.asin(math.sin(gamma) / across)
            cos_i = math.cos(gamma)
            cos_t = math.cos(inner)
            s = (cos_i - across * cos_t) / (cos_i + across * cos_t)
            p = (within * cos_i - cos_t) / (within * cos_i + cos_t)
            f = 0.5 * (s * s + p * p)
            chord = 2.0 * cos_t * eta / root
            for lobe in range(3):
                width = beta if lobe == 0 else (0.5 * beta if lobe == 1 else 2.0 * beta)
                shift = alpha if lobe == 0 else (-0.5 * alpha if lobe == 1 else -1.5 * alpha)
                d = (middle - shift) / width
                m = 0.5 * math.exp(-0.5 * d * d) / (math.sqrt(TURN) * width)
                seen = m * weight * bell(phi[i] - (2.0 * lobe * inner - 2.0 * gamma + lobe * math.pi), deviation)
                left = f if lobe == 0 else (1.0 - f) ** 2 * (f if lobe == 2 else 1.0)
                for c in range(3):
                    out[i, c] += seen * left * math.exp(-lobe * sigma[c] * chord)
