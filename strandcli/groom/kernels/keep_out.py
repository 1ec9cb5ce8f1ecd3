"""Moving particles of drawn strands out of solids."""

from __future__ import annotations

import functools
import math

import numpy as np

from ...constants import W
from ...jit import device
from ...jit.pruned import by_type
from ...simd import any_lane, broadcast, movemask, sqrt, where
from ...solids.kernels import custom
from ...solids.kernels.built_in import may_be_there
from ...solids.kernels.outside import deepest_in_shapes, outside

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)
CLEAR = np.float32(0.1)
"""Distance of particles from solids as a share of a segment: between two particles a curve lies below the surface of a
solid, and triangles may lie above their grid of distances."""
SLACK = np.float32(0.1)
"""Share of that distance by which particles may still be too near."""
LEVEL = np.float32(1e-6)
"""Square of a gradient that has no direction, at the most."""
ROUNDS = 3
SURE = np.float32(0.55)
"""Share of the distance from solids that a strand may go on unexamined: distances that are linear along the axes
between nodes of a grid grow by √3 a metre at most."""
FREE = np.float32(0.98)
"""The same from solids of the four shapes, whose distances are exact but for rounding."""
FAR = np.float32(1e6)


@device
def reach_on(solids, x, y, z, rest):
    """Return how far strands may go on from particles before any solid can be met, metres; 0 where that is not known.
    Vectors of lanes."""
    reach = max(-FREE * deepest_in_shapes(solids, x, y, z, broadcast(x, -FAR)) - CLEAR * rest, ZERO)
    return reach_past_custom(solids, x, y, z, rest, reach)


@custom.by_form(lambda solids, x, y, z, rest, reach: reach)
def reach_past_custom(form):
    """The same, of custom solids, where it is ``reach`` without them."""
    return lambda solids, x, y, z, rest, reach: min(
        reach, max(-SURE * (custom.deepen(solids, x, y, z, broadcast(x, -FAR)) + CLEAR * rest), ZERO)
    )


def stay(solids, p, o, rest, reach):
    """`slide_out` where no particle is moved."""
    reach = max(reach, reach_on(solids, p[0], p[1], p[2], rest))
    return p[0], p[1], p[2], reach, movemask(~(reach > 0.0))


@functools.partial(by_type, inline=True)
def move_out(solids, p, o, rest, reach):
    """`slide_out` where all solids are custom ones whose distances have gradients, else `stay`."""
    form = custom.form_of(solids)
    slides = form is not None and form.slopes_in_own is not None and not may_be_there(solids)
    return slide_out if slides else stay


def slide_out(solids, p, o, rest, reach):
    """Return particles p, moved along solids to where they are outside and at the distance ``rest`` from the particles
    before them, o; how far strands may go on from there before any solid can be met; and in which lanes, as bits, that
    has to be done by `keep_lane_out`. Vectors of lanes, metres; reach: how far they might go on before.

    A solid is taken to be flat about a particle, and looked at again where the particle has come to lie."""
    x, y, z = p
    clear = CLEAR * rest
    away, nx, ny, nz = custom.nearest_slope(solids, x, y, z)
    reach = max(reach, max(SURE * (away - clear), ZERO))
    touching = ~(reach > ZERO)
    lost = np.uint64(0)
    if any_lane(touching):
        for _ in range(ROUNDS):
            square = nx * nx + ny * ny + nz * nz
            lost |= movemask(touching & ~(square > LEVEL))
            touching = touching & (square > LEVEL)
            size = 1.0 / sqrt(max(square, LEVEL))
            nx, ny, nz = nx * size, ny * size, nz * size
            ex, ey, ez = x - o[0], y - o[1], z - o[2]
            along = ex * nx + ey * ny + ez * nz
            tx, ty, tz = ex - along * nx, ey - along * ny, ez - along * nz
            up = min(max(along + (clear - away), -rest), rest)
            f = sqrt(max(rest * rest - up * up, ZERO) / max(tx * tx + ty * ty + tz * tz, TINY))
            moved = touching & (clear - away > ZERO)
            x = where(moved, o[0] + up * nx + f * tx, x)
            y = where(moved, o[1] + up * ny + f * ty, y)
            z = where(moved, o[2] + up * nz + f * tz, z)
            away, nx, ny, nz = custom.nearest_slope(solids, x, y, z)
            touching = touching & (clear - away > SLACK * clear)
            if not any_lane(touching):
                break
    return x, y, z, reach, lost


@device
def keep_lane_out(rows, b, j, lane, rest, solids):
    """Move particle j of a lane of block b of rows (blocks, m + 1, 3 W) out of solids, as `keep_out`."""
    x = rows[b, j, lane]
    y = rows[b, j, W + lane]
    z = rows[b, j, 2 * W + lane]
    ox = rows[b, j - 1, lane]
    oy = rows[b, j - 1, W + lane]
    oz = rows[b, j - 1, 2 * W + lane]
    x, y, z = keep_out(x, y, z, ox, oy, oz, rest, solids)
    rows[b, j, lane] = x
    rows[b, j, W + lane] = y
    rows[b, j, 2 * W + lane] = z


@device
def keep_out(x, y, z, ox, oy, oz, rest, solids):
    """Return a particle (x, y, z), moved out of solids and to the distance ``rest`` from the particle before it,
    (ox, oy, oz), as nearly as `ROUNDS` iterations achieve; metres."""
    clear = CLEAR * rest
    for _ in range(ROUNDS):  # out of one solid may be into another, and changes the length
        qx, qy, qz = outside(x, y, z, clear, solids)
        if qx == x and qy == y and qz == z:
            break
        ex, ey, ez = unit(qx - ox, qy - oy, qz - oz)
        x, y, z = outside(ox + rest * ex, oy + rest * ey, oz + rest * ez, clear, solids)
    return x, y, z


@device
def unit(x, y, z):
    """Return the unit vector of a vector."""
    size = ONE / math.sqrt(max(x * x + y * y + z * z, TINY))
    return x * size, y * size, z * size
