"""Light scattered by one strand, per vertex and light: the Marschner model read from tables.

Conventions (Marschner et al. 2003, §2). t is the strand's unit tangent from root to tip; l and v are unit directions
from the strand to the light and to the eye. The inclination θ of a direction ω is measured from the plane normal to
the strand, sin θ = t·ω, so +90° is the tip's side and −90° the root's. φ in [0, π] is the angle between l and v
projected onto that plane: 0 is light coming back, π light passing through. With θ_h = (θ_l + θ_v) / 2 and
θ_d = (θ_v − θ_l) / 2,

    S cos θ_l = cos θ_l / cos² θ_d · Σ_p M_p(θ_h) N_p(θ_d, φ),    p = R, TT, TRT.

The cosine at the light is in the result: radiance averaged over the strand's width = E · result, where E is the
irradiance on a surface that faces the light. Add no other cosine.

Tables come from `strandcli.draw.fibre.marschner.build_tables`, which documents their contents and accuracy.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined
from ...common.kernels.approximations import acos, asin, clamp, exp2
from ...common.kernels.batch import EX, LX, NODE_X, NODE_Y, TRT, TT, TX, R, vector_at
from ...common.kernels.numbers import ONE, TWO, ZERO
from .highlights import shaded_by
from .lobes import add_lobes

TINY = np.float32(1e-20)

# Places in the array `lobes`.
SHIFT_R, SHIFT_TT, SHIFT_TRT = 0, 1, 2
FALL_R, FALL_TT, FALL_TRT = 3, 4, 5
THETA_SCALE, THETA_LAST, PHI_SCALE, PHI_LAST = 6, 7, 8, 9
COS2_FLOOR = 10
LOBES_SIZE = 11
NODE_SIZE = 8
"""Channels of a node of the array `nodes`, of which the eighth is padding, so that a node is half a cache line."""


@inlined
def longitudinal(tangent, light, eye, lobes):
    """The part that reads no table, without branches, so that a loop over it becomes vector code: the place (x, y) in
    the tables, and M_p cos θ_l / cos² θ_d of the three paths.

    tangent, light, eye: unit vectors. Directions need not be exactly of unit length: sines are clamped, and where t is
    parallel to l or v the undefined φ takes some value in [0, π].
    """
    tx, ty, tz = tangent
    lx, ly, lz = light
    vx, vy, vz = eye
    sin_l = clamp(tx * lx + ty * ly + tz * lz, -ONE, ONE)
    sin_v = clamp(tx * vx + ty * vy + tz * vz, -ONE, ONE)
    cos_l = np.sqrt(ONE - sin_l * sin_l)
    cos_v = np.sqrt(ONE - sin_v * sin_v)
    sines = sin_l * sin_v
    cosines = cos_l * cos_v
    theta_l = asin(sin_l)
    theta_v = asin(sin_v)
    phi = acos(clamp((lx * vx + ly * vy + lz * vz - sines) / max(cosines, TINY), -ONE, ONE))
    # the last node's index is approached, never reached, so the cell's far corner exists
    x = clamp(abs(theta_v - theta_l) * lobes[THETA_SCALE], ZERO, lobes[THETA_LAST])
    y = clamp(phi * lobes[PHI_SCALE], ZERO, lobes[PHI_LAST])
    # twice θ_h serves as the argument of the Gaussians; their widths and shifts are scaled to suit
    total = theta_l + theta_v
    d_r = total - lobes[SHIFT_R]
    d_tt = total - lobes[SHIFT_TT]
    d_trt = total - lobes[SHIFT_TRT]
    # 1 + cos 2θ_d = 2 cos² θ_d
    scale = TWO * cos_l / max(ONE + cosines + sines, lobes[COS2_FLOOR])
    m_r = scale * exp2(d_r * d_r * lobes[FALL_R])
    m_tt = scale * exp2(d_tt * d_tt * lobes[FALL_TT])
    m_trt = scale * exp2(d_trt * d_trt * lobes[FALL_TRT])
    return x, y, m_r, m_tt, m_trt


@device
def highlights(work, n, lights, i, tables):
    """Add the light that strands scatter once of light number i, at the first n vertices of a batch.

    work: rows of `batch`, of which those of directions, of what arrives and of extra absorption are read, and the
    radiance is added to, finite and not negative whatever they are; lights: columns of `light_columns`; tables:
    `MarschnerArrays`.
    """
    for k in range(n):
        x, y, r, tt, trt = longitudinal(
            vector_at(work, TX, k), vector_at(work, LX, k), vector_at(work, EX, k), tables.lobes
        )
        work[NODE_X + k] = x
        work[NODE_Y + k] = y
        work[R + k] = r
        work[TT + k] = tt
        work[TRT + k] = trt
    add_lobes(work, n, lights, i, None, tables)


@shaded_by(highlights)
class MarschnerArrays(NamedTuple):
    """Tables of Marschner's model as kernels read them, float32 in C order.

    θ_d and φ are even in angle over [0, π/2] and [0, π].
    """

    lobes: NDArray[np.float32]
    """(11,) shifts, widths and index scales, at the places named above."""
    nodes: NDArray[np.float32]
    """(n_θ, n_φ, 8) R, TT rgb, TRT rgb, 0: N_p times the peak of M_p times material.specular."""
    paths: NDArray[np.float32]
    """(n_θ, n_φ, 2) log₂ e times the mean path length in TT and TRT, in radii; no nodes where no colour varies."""
