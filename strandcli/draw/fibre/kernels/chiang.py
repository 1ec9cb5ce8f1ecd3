"""Light scattered by one strand after Chiang, Bitterli, Tappan & Burley (2016), averaged over the strand's width.

Directions and angles are those of `kernels/marschner.py`. With θ_l, θ_v the inclinations of light and eye,

    S cos θ_l = Σ_p M_p(θ_l, θ_v) N_p(θ_v, φ),    p = R, TT, TRT and all that leaves after more inner reflections.

M is that of d'Eon et al. (2011), a von Mises-Fisher lobe averaged over azimuth, so ∫ M_p cos θ_l dθ_l = 1 at any θ_v;
N_p, the attenuation and the azimuthal logistic averaged over h ∈ [−1, 1], comes from the tables of
`strandcli.draw.fibre.chiang`. As in `marschner`, the cosine at the light is in the result. The form is energy
conserving and not reciprocal.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, function, inlined
from ...common.kernels.approximations import acos, asin, clamp, exp2
from ...common.kernels.batch import EX, LX, NODE_X, NODE_Y, REST, TRT, TT, TX, R, vector_at
from ...common.kernels.numbers import ONE, ZERO
from .highlights import shaded_by
from .lobes import add_lobes

TINY = np.float32(1e-20)
HALF_LOG2_E = np.float32(0.5 / math.log(2.0))

# Places in the array `lobes`, a number for each of the four lobes: 1 / v, normalisation, the tilt's cosine and sine.
SHARP, NORM, COS, SIN = 0, 4, 8, 12
THETA_SCALE, THETA_LAST, PHI_SCALE, PHI_LAST = 16, 17, 18, 19
LOBES_SIZE = 20
NODE_SIZE = 12
"""Channels of a node of the array `nodes`, of which the last two are padding."""

# e^-x I₀(x) = √(P(x) / Q(x)), exact at 0 and ∞, 2.8e-5 off at most, without a seam anywhere: a fit made for this file
P1, P2, P3, P4 = (np.float32(c) for c in (0.35561753, 0.30034769, 0.07188076, 0.05166444))
Q1, Q2, Q3, Q4, Q5 = (np.float32(c) for c in (2.35823106, 2.47816869, 1.66911563, 0.37260530, 0.32461725))


@function
def scaled_bessel(x: np.float32) -> np.float32:
    """e^-x I₀(x) for 0 <= x <= 1e7."""
    p = ONE + x * (P1 + x * (P2 + x * (P3 + x * P4)))
    q = ONE + x * (Q1 + x * (Q2 + x * (Q3 + x * (Q4 + x * Q5))))
    return np.sqrt(p / q)


@inlined
def lobe(
    sin_l: np.float32, cos_l: np.float32, sin_v: np.float32, cos_v: np.float32, sharp: np.float32, norm: np.float32
) -> np.float32:
    """d'Eon's M at 1 / v = `sharp`, norm = sharp / (1 − e^(−2 sharp)): its exponent, (cos (θ_l + θ_v) − 1) / v, as the
    square of a distance, which loses no digits however narrow the lobe."""
    c = cos_l - cos_v
    s = sin_l + sin_v
    fall = -HALF_LOG2_E * sharp * (c * c + s * s)
    return norm * exp2(fall) * scaled_bessel(sharp * cos_l * cos_v)


@inlined
def longitudinal(tangent, light, eye, lobes):
    """The part that reads no table, without branches: the place (x, y) in the tables, and M_p of the four lobes."""
    tx, ty, tz = tangent
    lx, ly, lz = light
    vx, vy, vz = eye
    sin_l = clamp(tx * lx + ty * ly + tz * lz, -ONE, ONE)
    sin_v = clamp(tx * vx + ty * vy + tz * vz, -ONE, ONE)
    # from what is across the strand, not from 1 − sin²: near the strand's own direction that has no digits left
    lx -= sin_l * tx
    ly -= sin_l * ty
    lz -= sin_l * tz
    vx -= sin_v * tx
    vy -= sin_v * ty
    vz -= sin_v * tz
    cos_l = min(np.sqrt(lx * lx + ly * ly + lz * lz), ONE)
    cos_v = min(np.sqrt(vx * vx + vy * vy + vz * vz), ONE)
    phi = acos(clamp((lx * vx + ly * vy + lz * vz) / max(cos_l * cos_v, TINY), -ONE, ONE))
    x = clamp(abs(asin(sin_v)) * lobes[THETA_SCALE], ZERO, lobes[THETA_LAST])
    y = clamp(phi * lobes[PHI_SCALE], ZERO, lobes[PHI_LAST])
    m_r = tilted(sin_l, cos_l, sin_v, cos_v, lobes, np.int64(0))
    m_tt = tilted(sin_l, cos_l, sin_v, cos_v, lobes, np.int64(1))
    m_trt = tilted(sin_l, cos_l, sin_v, cos_v, lobes, np.int64(2))
    m_rest = lobe(sin_l, cos_l, sin_v, cos_v, lobes[SHARP + 3], lobes[NORM + 3])
    return x, y, m_r, m_tt, m_trt, m_rest


@inlined
def tilted(sin_l, cos_l, sin_v, cos_v, lobes, p):
    """M of a lobe that the scales tilt."""
    s = sin_v * lobes[COS + p] + cos_v * lobes[SIN + p]
    c = abs(cos_v * lobes[COS + p] - sin_v * lobes[SIN + p])
    return lobe(sin_l, cos_l, s, c, lobes[SHARP + p], lobes[NORM + p])


@device
def highlights(work, n, lights, i, tables):
    """Add the light that strands scatter once, as `kernels.marschner.highlights`; tables: `ChiangArrays`."""
    for k in range(n):
        x, y, r, tt, trt, rest = longitudinal(
            vector_at(work, TX, k), vector_at(work, LX, k), vector_at(work, EX, k), tables.lobes
        )
        work[NODE_X + k] = x
        work[NODE_Y + k] = y
        work[R + k] = r
        work[TT + k] = tt
        work[TRT + k] = trt
        work[REST + k] = rest
    add_lobes(work, n, lights, i, REST, tables)


@shaded_by(highlights)
class ChiangArrays(NamedTuple):
    """Tables of Chiang's model as kernels read them, float32 in C order.

    θ_v and φ are even in angle over [0, π/2] and [0, π].
    """

    lobes: NDArray[np.float32]
    """(20,) sharpness, normalisation and tilt of the lobes, and index scales, at the places named above."""
    nodes: NDArray[np.float32]
    """(n_θ, n_φ, 12) N_p of R, TT rgb, TRT rgb, the rest rgb, 0, 0."""
    paths: NDArray[np.float32]
    """(n_θ, n_φ, 4) log₂ e times the mean path length in TT, TRT and the rest, in radii, 0; no nodes where no colour
    varies."""
