"""Combed parts of tied strands: kept outside of solids, and moved with the emitter."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import device, parallel, prange
from ...meshes.kernels.distance import distance as grid_distance
from ...solids.shapes.capsule import AXIS_X, AXIS_Y, AXIS_Z, PER_SQUARE, RADIUS, X, Y, Z

STEPS = 128
"""Steps of sphere tracing at most; one is enough where the normal is perpendicular to the surface."""
ENOUGH = 1e-7
"""Depth below a surface that counts as outside, metres."""


@parallel
def lift(points, normals, capsules, out):
    """Write to out (N,) how far points (N, 3) must move along unit normals (N, 3) to be outside of capsules, metres.

    capsules (m, 9) float64: columns of `strandcli.solids.shapes.capsule`. Their distance is never greater than that
    along any line to their surface, so sphere tracing (Hart 1996) does not pass through the surface.
    """
    for i in prange(points.shape[0]):
        up = 0.0
        for _ in range(STEPS):
            away = distance(
                points[i, 0] + up * normals[i, 0], points[i, 1] + up * normals[i, 1], points[i, 2] + up * normals[i, 2],
                capsules,
            )  # fmt: skip
            if away >= -ENOUGH:
                break
            up -= away
        out[i] = up


@parallel
def lift_off_mesh(points, normals, grid, clear, out):
    """Write to out (N,) how far points (N, 3) must move along unit normals (N, 3) to be ``clear`` metres outside of a
    mesh, of which grid is the `meshes.kernels.distance.DistanceGrid`."""
    for i in prange(points.shape[0]):
        up = 0.0
        for _ in range(STEPS):
            away = grid_distance(
                grid, points[i, 0] + up * normals[i, 0], points[i, 1] + up * normals[i, 1],
                points[i, 2] + up * normals[i, 2],
            )  # fmt: skip
            if away >= clear - ENOUGH:
                break
            up += clear - away
        out[i] = up


@device
def distance(x, y, z, capsules):
    """Return the signed distance of a point from the union of all capsules, metres, negative inside."""
    least = np.inf
    for m in range(capsules.shape[0]):
        ox = x - capsules[m, X]
        oy = y - capsules[m, Y]
        oz = z - capsules[m, Z]
        t = ox * capsules[m, AXIS_X] + oy * capsules[m, AXIS_Y] + oz * capsules[m, AXIS_Z]
        t = min(max(t * capsules[m, PER_SQUARE], 0.0), 1.0)
        ox -= t * capsules[m, AXIS_X]
        oy -= t * capsules[m, AXIS_Y]
        oz -= t * capsules[m, AXIS_Z]
        least = min(least, math.sqrt(ox * ox + oy * oy + oz * oz) - capsules[m, RADIUS])
    return least


@parallel
def join(combed, hanging, rotation, shift, out):
    """Write strands from root to tip to out: the combed part, moved with the emitter, then the hanging part.

    combed (blocks, 1 + P, 3 W) float32 in the emitter's frame: the row before the root, then the points to the tie;
    hanging (blocks, n + 1, 3 W) metres: row 1 is at the tie, row 0 is not used; rotation (9,) by rows
    and shift (3,) float32: the emitter's pose; out (blocks, 1 + P + n, 3 W).
    """
    rows = combed.shape[1]
    for block in prange(out.shape[0]):
        for row in range(rows):
            for c in range(3):
                a = rotation[3 * c]
                b = rotation[3 * c + 1]
                d = rotation[3 * c + 2]
                e = shift[c]
                for k in range(W):
                    x = combed[block, row, k]
                    y = combed[block, row, W + k]
                    z = combed[block, row, 2 * W + k]
                    out[block, row, c * W + k] = (a * x + b * y) + d * z + e
        for row in range(1, hanging.shape[1]):
            for k in range(3 * W):
                out[block, rows + row - 1, k] = hanging[block, row, k]
