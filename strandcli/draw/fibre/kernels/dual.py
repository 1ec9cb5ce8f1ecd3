"""Light that comes to a strand by way of others: dual scattering, as `strandcli.draw.fibre.dual` explains."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import function, inlined
from ...common.kernels.approximations import asin, clamp, exp
from ...common.kernels.numbers import INV_PI, ONE, TWO, ZERO
from .chiang import lobe

TINY = np.float32(1e-12)
SLANT = np.float32(math.sqrt(2.0))
"""Of light at 45° to the way that strands are counted along, what they meet over what crosses it."""
PER_QUARTER = np.float32(2.0 / math.pi)
LEAST = np.float32(1e-4)
PALER = np.float32(4.0)

# Channels: rgb of the streams' κ, R, k₀, P and Q, and of the mean and the cosine over φ of all that a strand scatters;
# variance of a passage, of light from behind, and of the strand's own lobes.
DECAY, MIRROR, BEAM, ON, BACK, ROUND, COSINE = 0, 3, 6, 9, 12, 15, 18
SPREAD, WIDTH, OWN = 21, 22, 23

HALF_WAY = np.float32(2.0)
"""Optical depth τ at the middle of the table of light that strands take from what lies behind them."""

MEAN_DECAY, MEAN_MIRROR, MEAN_BEAM, MEAN_ON, MEAN_BACK = range(5)
"""Rows of the averaged streams: κ, R, k₀, P and Q."""


class DualArrays(NamedTuple):
    """Tables of dual scattering as kernels read them, float32."""

    rows: NDArray[np.float32]
    """(n_θ, 24) over θ_l in [0, π/2], even in angle: the channels named above."""
    scale: NDArray[np.float32]
    """(3,) one over the colour of a mass of strands with the tables' absorption."""


@inlined
def angles(tangent, light, eye, nodes):
    """sin θ and cos θ of light and eye, cos φ, and the place among so many `nodes` of the tables."""
    tx, ty, tz = tangent
    lx, ly, lz = light
    vx, vy, vz = eye
    sin_l = clamp(tx * lx + ty * ly + tz * lz, -ONE, ONE)
    sin_v = clamp(tx * vx + ty * vy + tz * vz, -ONE, ONE)
    cos_l = np.sqrt(ONE - sin_l * sin_l)
    cos_v = np.sqrt(ONE - sin_v * sin_v)
    cos_phi = clamp((lx * vx + ly * vy + lz * vz - sin_l * sin_v) / max(cos_l * cos_v, TINY), -ONE, ONE)
    edge = np.float32(nodes - 1)
    return sin_l, cos_l, sin_v, cos_v, cos_phi, clamp(abs(asin(sin_l)) * PER_QUARTER, ZERO, ONE) * edge


@inlined
def lobes(sin_l, cos_l, sin_v, cos_v, passed, spread, width, own):
    """M of light that comes back from strands further on, and of light that has come through `passed` strands."""
    back = wide(sin_l, cos_l, sin_v, cos_v, own + width)
    through = wide(sin_l, cos_l, sin_v, cos_v, own + max(passed, ONE) * spread)
    return back, through


@inlined
def wide(sin_l, cos_l, sin_v, cos_v, variance):
    """d'Eon's lobe of any variance."""
    sharp = ONE / max(variance, LEAST)
    return lobe(sin_l, cos_l, sin_v, cos_v, sharp, sharp / (ONE - exp(-TWO * sharp)))


@function
def through(passed, streams, c):
    """Share of a light that arrives in channel c behind `passed` strands, with what they scatter on.

    streams (5, 3): rows above, averaged. As in `scattered` where nothing is behind: τ' = 0.
    """
    straight = exp(-streams[MEAN_BEAM, c] * passed)
    near = exp(-streams[MEAN_DECAY, c] * passed)
    mirror = streams[MEAN_MIRROR, c]
    back = streams[MEAN_BACK, c] * straight
    returned = mirror * near
    first = (returned * back - streams[MEAN_ON, c]) / (ONE - returned * returned)
    final = -back - first * returned
    return straight + max(first * near + final * mirror + streams[MEAN_ON, c] * straight, ZERO)


@inlined
def scattered(passed, left, direct, cos_phi, lobes, streams, round_about, tone):
    """S cos θ_l in one channel: of all streams where `passed` strands are between the light and here, and `left` from
    here on; `direct` of the light arrives unscattered.

    lobes: M of what comes back and of what came through; streams: κ, R, k₀, P and Q; round_about: mean over φ of all
    that a strand scatters, and its cosine; tone: scale for the strand's colour.
    """
    back, through = lobes
    decay, mirror, beam, on, behind = streams
    all_round, cosine = round_about
    straight = exp(-beam * passed)
    near = exp(-decay * passed)
    far = exp(-decay * left)
    last = behind * straight * exp(-beam * left)
    returned = mirror * near * far
    first = (returned * last - on) / (ONE - returned * returned)
    final = -last - first * returned
    down = max(first * near + final * mirror * far + on * straight, ZERO)
    up = max(first * mirror * near + final * far + behind * straight, ZERO)
    light = max(all_round + cosine * cos_phi, ZERO) * SLANT * down
    second = (ONE - beam) * (ONE - beam) * INV_PI * (TWO * cos_phi * cos_phi - ONE)
    light += max(all_round + cosine * cos_phi + second, ZERO) * max(straight - direct, ZERO)
    turned = max(all_round - cosine * cos_phi, ZERO) * SLANT * up
    return (light * through + turned * back) * min(tone, PALER)
