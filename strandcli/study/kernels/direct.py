"""Light of a strand without tables: the integral over the offset h for every direction anew."""

from __future__ import annotations

import math

import numpy as np

from ...draw.fibre.kernels.chiang import scaled_bessel
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
def marschner(theta_l, theta_v, phi, eta, alpha, beta, deviation, sigma, nodes, out):
    """S cos θ_l of Marschner's model by the midpoint rule over ``nodes`` offsets h, even in their angle.

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


@function
def logistic(angle, scale):
    """The logistic distribution wound round the circle by its nearest turn, and trimmed to it."""
    a = abs(angle - TURN * np.floor(angle / TURN + 0.5))
    fall = math.exp(-a / scale)
    return fall / (scale * (1.0 + fall) ** 2) / math.tanh(0.25 * TURN / scale)


@parallel
def chiang(theta_l, theta_v, phi, eta, variances, tilts, scale, sigma, nodes, out):
    """S cos θ_l of Chiang's model by the same rule.

    variances, tilts (4,): of the lobes along the strand, R, TT, TRT and the rest; scale: of the logistic round it;
    sigma (3,) in 1/radius; the others as in `marschner`.
    """
    for i in prange(theta_l.shape[0]):
        cos_v = math.cos(theta_v[i])
        root = math.sqrt(eta * eta - math.sin(theta_v[i]) ** 2)
        m = np.empty(4)
        for p in range(4):
            turned = theta_v[i] + tilts[p]
            x = math.cos(theta_l[i]) * abs(math.cos(turned)) / variances[p]
            fall = x - (math.sin(theta_l[i]) * math.sin(turned) + 1.0) / variances[p]
            m[p] = scaled_bessel(x) * math.exp(fall) / (variances[p] * -math.expm1(-2.0 / variances[p]))
        for c in range(3):
            out[i, c] = 0.0
        for k in range(nodes):
            gamma = ((k + 0.5) / nodes - 0.5) * math.pi
            weight = 0.5 * math.cos(gamma) * math.pi / nodes
            inner = math.asin(math.sin(gamma) * cos_v / root)
            cos_i = cos_v * math.cos(gamma)
            cos_t = math.sqrt(1.0 - (1.0 - cos_i * cos_i) / (eta * eta))
            s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
            p_ = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
            f = 0.5 * (s * s + p_ * p_)
            r = m[0] * logistic(phi[i] + 2.0 * gamma, scale)
            tt = m[1] * logistic(phi[i] - (2.0 * inner - 2.0 * gamma + 0.5 * TURN), scale)
            trt = m[2] * logistic(phi[i] - (4.0 * inner - 2.0 * gamma + TURN), scale)
            chord = 2.0 * math.cos(inner) * eta / root
            for c in range(3):
                t = math.exp(-sigma[c] * chord)
                twice = (1.0 - f) ** 2 * t
                rest = twice * f * f * t * t / (1.0 - f * t)
                out[i, c] += weight * (f * r + twice * (tt + f * t * trt) + rest * m[3] / TURN)
