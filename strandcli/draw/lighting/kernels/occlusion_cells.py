"""Accumulation of strands in the grid of ambient occlusion (see `occlusion_sweep`)."""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, function
from ....jit.indices import FIRST, SECOND, THIRD
from ...common.kernels.numbers import HALF, ONE, ZERO
from . import occlusion


@function
def count_strands(positions, chosen, width, taper, scale, shares, weight, box, cells):
    """Add the strands chosen (N,) int64 of positions (blocks, n + 1, 3 W) to the cells (V, CHANNELS), times ``weight``.

    width: metres at the root, smaller by the share `taper` at the tip; scale (strands,): factor of each strand's width,
    or None; shares (strands, n): of that at each point, in place of the taper, or None; box (`BOX_SIZE`,), cells:
    columns of `occlusion`.
    """
    n = positions.shape[1] - 1
    for s in chosen:
        block = s // W
        lane = s % W
        own = weight * (width if scale is None else width * scale[s])
        x = positions[block, 1, lane]
        y = positions[block, 1, W + lane]
        z = positions[block, 1, 2 * W + lane]
        for j in range(2, n + 1):
            dx = positions[block, j, lane] - x
            dy = positions[block, j, W + lane] - y
            dz = positions[block, j, 2 * W + lane] - z
            length = math.sqrt(dx * dx + dy * dy + dz * dz)
            if length > ZERO:
                if shares is None:
                    w = own * (ONE - taper * (np.float32(j) - np.float32(1.5)) / np.float32(n - 1))
                else:
                    w = own * (HALF * (shares[s, j - 2] + shares[s, j - 1]))
                piece(x, y, z, dx, dy, dz, length, w, box, cells)
            x += dx
            y += dy
            z += dz


@device
def piece(x, y, z, dx, dy, dz, length, width, box, cells):
    """Add a straight segment to the cells, with one sample for each cell along the axis on which it crosses most."""
    most = max(
        max(abs(dx) * box[occlusion.PER_METRE_X], abs(dy) * box[occlusion.PER_METRE_Y]),
        abs(dz) * box[occlusion.PER_METRE_Z],
    )
    steps = np.ceil(min(most, np.float32(1e4))) + ONE
    per = ONE / steps
    share = width * length * per
    tx = dx / length
    ty = dy / length
    tz = dz / length
    for i in range(np.int64(steps)):
        t = (np.float32(i) + HALF) * per
        a = place(x + t * dx, box, FIRST)
        b = place(y + t * dy, box, SECOND)
        c = place(z + t * dz, box, THIRD)
        cell = (a * np.int64(box[occlusion.COUNT_Y]) + b) * np.int64(box[occlusion.COUNT_Z]) + c
        cells[cell, occlusion.DENSITY] += share
        cells[cell, occlusion.XX] += share * tx * tx
        cells[cell, occlusion.XY] += share * tx * ty
        cells[cell, occlusion.XZ] += share * tx * tz
        cells[cell, occlusion.YY] += share * ty * ty
        cells[cell, occlusion.YZ] += share * ty * tz
        cells[cell, occlusion.ZZ] += share * tz * tz


@device
def place(x, box, axis):
    """Return the number of the cell along an axis, clamped to the grid."""
    u = (x - box[occlusion.MIDDLE_X + axis]) * box[occlusion.PER_METRE_X + axis] + HALF
    return np.int64(min(max(u, ZERO), box[occlusion.COUNT_X + axis] - ONE))
