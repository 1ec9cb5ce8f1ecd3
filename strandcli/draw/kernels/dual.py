"""Light that comes to a strand by way of others: dual scattering, as `strandcli.draw.dual` explains."""

from __future__ import annotations

import math

import numpy as np

from ...jit import function
from .approximations import asin, clamp, exp
from .chiang import lobe

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
TINY = np.float32(1e-12)
DENSITY = np.float32(0.7)
HALF_ROUND = np.float32(2.0 / math.pi)
INV_2PI = np.float32(0.5 / math.pi)
PER_QUARTER = np.float32(2.0 / math.pi)
LEAST = np.float32(1e-4)
PALER = np.float32(4.0)

# Channels: rgb of what a strand does not send forward, of A_b, of the mean and the cosine over φ of all that it
# scatters; variance of a passage, of A_b, shift of A_b, variance of the strand's own lobes.
STOPPED, BACKWARD, ROUND, COSINE = 0, 3, 6, 9
SPREAD, WIDTH, SHIFT, OWN = 12, 13, 14, 15
CHANNELS = 16


@function
def angles(tx, ty, tz, lx, ly, lz, vx, vy, vz, nodes):
    """sin θ and cos θ of light and eye, cos φ, and the place among so many `nodes` of the tables."""
    sin_l = clamp(tx * lx + ty * ly + tz * lz, -ONE, ONE)
    sin_v = clamp(tx * vx + ty * vy + tz * vz, -ONE, ONE)
    cos_l = np.sqrt(ONE - sin_l * sin_l)
    cos_v = np.sqrt(ONE - sin_v * sin_v)
    cos_phi = clamp((lx * vx + ly * vy + lz * vz - sin_l * sin_v) / max(cos_l * cos_v, TINY), -ONE, ONE)
    edge = np.float32(nodes - 1)
    return sin_l, cos_l, sin_v, cos_v, cos_phi, clamp(abs(asin(sin_l)) * PER_QUARTER, ZERO, ONE) * edge


@function
def lobes(sin_l, cos_l, sin_v, cos_v, passed, spread, width, shift, own):
    """M of light that comes back from the strands about, and of light that has come through `passed` strands."""
    back = wide(sin_l, cos_l, sin_v - shift * cos_v, cos_v, width)
    through = wide(sin_l, cos_l, sin_v, cos_v, own + max(passed, ONE) * spread)
    return back, through


@function
def wide(sin_l, cos_l, sin_v, cos_v, variance):
    """d'Eon's lobe of any variance."""
    sharp = ONE / max(variance, LEAST)
    return lobe(sin_l, cos_l, sin_v, cos_v, sharp, sharp / (ONE - exp(-TWO * sharp)))


@function
def scattered(passed, direct, cos_phi, back, through, stopped, backward, all_round, cosine, tone):
    """S cos θ_l in one channel; `direct` of the light arrives unscattered; `tone` scales for the strand's colour."""
    forward = DENSITY * max(exp(-passed * stopped) - direct, ZERO)
    near = DENSITY * backward * INV_2PI
    whole = direct * near * back * (ONE + cos_phi)
    whole += forward * through * (max(all_round + cosine * cos_phi, ZERO) + near * (ONE + HALF_ROUND * cos_phi))
    return whole * min(tone, PALER)
