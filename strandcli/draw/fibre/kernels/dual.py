"""Light that comes to a strand through its neighbours: dual scattering, as `strandcli.draw.fibre.dual` explains."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import W
from ....jit import device, function, inlined
from ....simd import floor, gather4, lane_count, load, pointer, store, store3
from ...common.kernels import batch as row
from ...common.kernels.approximations import asin, clamp, exp
from ...common.kernels.batch import ARRIVES, COLOUR, LX, LY, LZ, RADIANCE, TX, TY, TZ
from ...common.kernels.light_columns import POWER_B, POWER_G, POWER_R
from ...common.kernels.numbers import INV_PI, ONE, TWO, ZERO
from .chiang import lobe

TINY = np.float32(1e-12)
SLANT = np.float32(math.sqrt(2.0))
"""Of light at 45° to the direction that strands are counted along, what they meet over what crosses it."""
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


@device
def dual_scattering(work, n, lights, one, tables):
    """Add the light of number `one` that comes through other strands, at the first n vertices of a batch.

    work: rows of `batch`, of which those of directions, strands before and behind, and of what arrives without strands
    are read; tables: `DualArrays`.
    """
    rows = tables.rows
    nodes = rows.shape[0]
    for k in range(n):
        sin_l, cos_l, sin_v, cos_v, cos_phi, place = angles(
            row.vector_at(work, row.TX, k), row.vector_at(work, row.LX, k), row.vector_at(work, row.EX, k), nodes
        )
        work[row.SIN_L + k] = sin_l
        work[row.COS_L + k] = cos_l
        work[row.SIN_V + k] = sin_v
        work[row.COS_V + k] = cos_v
        work[row.COS_PHI + k] = cos_phi
        work[row.PLACE + k] = place
    look_up(work, n, rows)
    for k in range(n):
        back, through = lobes(
            work[row.SIN_L + k], work[row.COS_L + k], work[row.SIN_V + k], work[row.COS_V + k], work[row.PASSED + k],
            work[row.TABLE + SPREAD * W + k], work[row.TABLE + WIDTH * W + k],
            work[row.TABLE + OWN * W + k],
        )  # fmt: skip
        work[row.RETURNED + k] = back
        work[row.FORWARD + k] = through
    for c in range(3):
        power = lights[one, POWER_R + c]
        per = tables.scale[c]
        for k in range(n):
            s = scattered(
                work[row.PASSED + k], work[row.LEFT + k], exp(-work[row.PASSED + k]), work[row.COS_PHI + k],
                (work[row.RETURNED + k], work[row.FORWARD + k]),
                (work[row.TABLE + (DECAY + c) * W + k], work[row.TABLE + (MIRROR + c) * W + k],
                 work[row.TABLE + (BEAM + c) * W + k], work[row.TABLE + (ON + c) * W + k],
                 work[row.TABLE + (BACK + c) * W + k]),
                (work[row.TABLE + (ROUND + c) * W + k], work[row.TABLE + (COSINE + c) * W + k]),
                work[row.COLOUR + c * W + k] * per,
            )  # fmt: skip
            work[row.RADIANCE + c * W + k] += work[row.UNBLOCKED + k] * power * s


@device
def look_up(work, n, table):
    """Store the rows `TABLE` at the places `PLACE` of the first n vertices; table (n_θ, CHANNELS)."""
    for k in range(n, W):  # the unused lanes of the last vector must read valid nodes
        work[row.PLACE + k] = ZERO
    rows, nodes = pointer(work), pointer(table)
    last = np.float32(table.shape[0] - 2)
    for k in range(0, n, lane_count(rows)):
        place = load(rows, row.PLACE + k)
        i = min(floor(place), last)
        part = place - i
        for c in range(0, row.CHANNELS, 4):
            low = gather4(nodes, c, i, row.CHANNELS, ZERO)
            high = gather4(nodes, c + row.CHANNELS, i, row.CHANNELS, ZERO)
            store3(
                rows, row.TABLE + c * W + k, W,
                low[0] + part * (high[0] - low[0]), low[1] + part * (high[1] - low[1]),
                low[2] + part * (high[2] - low[2]),
            )  # fmt: skip
            store(rows, row.TABLE + (c + 3) * W + k, low[3] + part * (high[3] - low[3]))


@device
def diffuse_light(work, n, lights, i, scale):
    """Add the diffuse term of light number i to the radiance of the first n vertices of a batch; scale:
    `material.diffuse`."""
    for k in range(n):
        d = scale * kajiya_diffuse(work[TX + k], work[TY + k], work[TZ + k], work[LX + k], work[LY + k], work[LZ + k])
        d *= work[ARRIVES + k]
        work[RADIANCE + k] += lights[i, POWER_R] * (d * work[COLOUR + k])
        work[RADIANCE + W + k] += lights[i, POWER_G] * (d * work[COLOUR + W + k])
        work[RADIANCE + 2 * W + k] += lights[i, POWER_B] * (d * work[COLOUR + 2 * W + k])


@function
def kajiya_diffuse(tx, ty, tz, lx, ly, lz):
    """cos θ_l / π, in 1/sr: Kajiya and Kay's (1989) diffuse term, sin(t, l), scaled to bound the light of a mass.

    Radiance = E · material.diffuse · colour · result, the same from everywhere. It stands for light scattered from
    strand to strand, so its bound is set for a mass of strands: an opaque one under a facing light has the exitance
    diffuse · colour · E, as a Lambertian surface of that albedo. (A lone strand in the open returns π times that.)
    """
    s = clamp(tx * lx + ty * ly + tz * lz, -ONE, ONE)
    return np.sqrt(ONE - s * s) * INV_PI
