"""Light scattered by one strand, per vertex and light: the Marschner model read from tables, and a diffuse stand-in.

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

import math

import numpy as np

from ....jit import function, inlined
from ...common.kernels.approximations import acos, asin, clamp, exp2
from .lobes import azimuthal

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
INV_PI = np.float32(1.0 / math.pi)
TINY = np.float32(1e-20)

# Places in the array `lobes`.
SHIFT_R, SHIFT_TT, SHIFT_TRT = 0, 1, 2
FALL_R, FALL_TT, FALL_TRT = 3, 4, 5
THETA_SCALE, THETA_LAST, PHI_SCALE, PHI_LAST = 6, 7, 8, 9
COS2_FLOOR = 10
LOBES_SIZE = 11
NODE_SIZE = 8
"""Channels of a node of the array `nodes`, of which the eighth is padding, so that a node is half a cache line."""


@function
def marschner(
    tx: np.float32, ty: np.float32, tz: np.float32,
    lx: np.float32, ly: np.float32, lz: np.float32,
    vx: np.float32, vy: np.float32, vz: np.float32,
    lobes: np.ndarray, nodes: np.ndarray,
    paths: np.ndarray | None, extra_r: np.float32, extra_g: np.float32, extra_b: np.float32,
) -> tuple[np.float32, np.float32, np.float32]:  # fmt: skip
    """S cos θ_l in red, green and blue, in 1/sr: finite and not negative whatever the arguments.

    ``lobes`` (11,), ``nodes`` (n_θ, n_φ, 8) and ``paths`` (n_θ, n_φ, 2) are float32, C order; every scalar is float32.
    ``extra_*`` is this strand's absorption less that of the tables, in 1/radius; with ``paths`` None the tables' colour
    is taken, ``extra_*`` is not read, and the code for it is not compiled. Directions need not be exactly of unit
    length: sines are clamped, and where t is parallel to l or v the undefined φ takes some value in [0, π].
    """
    x, y, m_r, m_tt, m_trt = longitudinal(tx, ty, tz, lx, ly, lz, vx, vy, vz, lobes)
    return azimuthal(x, y, m_r, m_tt, m_trt, None, nodes, paths, extra_r, extra_g, extra_b)


@inlined
def longitudinal(
    tx: np.float32, ty: np.float32, tz: np.float32,
    lx: np.float32, ly: np.float32, lz: np.float32,
    vx: np.float32, vy: np.float32, vz: np.float32,
    lobes: np.ndarray,
) -> tuple[np.float32, np.float32, np.float32, np.float32, np.float32]:  # fmt: skip
    """The part of `marschner` that reads no table, without branches, so that a loop over it becomes vector code: the
    place (x, y) in the tables, and M_p cos θ_l / cos² θ_d of the three paths."""
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


@function
def kajiya_diffuse(
    tx: np.float32, ty: np.float32, tz: np.float32, lx: np.float32, ly: np.float32, lz: np.float32
) -> np.float32:
    """cos θ_l / π, in 1/sr: Kajiya and Kay's (1989) diffuse term, sin(t, l), scaled to bound the light of a mass.

    Radiance = E · material.diffuse · colour · result, the same from everywhere. It stands for light scattered from
    strand to strand, so its bound is set for a mass of strands: an opaque one under a facing light has the exitance
    diffuse · colour · E, as a Lambertian surface of that albedo. (A lone strand in the open returns π times that.)
    """
    s = clamp(tx * lx + ty * ly + tz * lz, -ONE, ONE)
    return np.sqrt(ONE - s * s) * INV_PI
