"""Combed parts of tied strands: outside of the mesh that they grow on, and moved with the emitter."""

from __future__ import annotations

from ...constants import W
from ...jit import parallel, prange
from ...meshes.kernels.distance import distance

STEPS = 128
"""Steps of sphere tracing at most; one is enough where the normal is perpendicular to the surface."""
ENOUGH = 1e-7
"""Depth below a surface that counts as outside, metres."""


@parallel
def lift_off_mesh(points, normals, grid, clear, out):
    """Write to out (N,) how far points (N, 3) must move along unit normals (N, 3) to be ``clear`` metres outside of a
    mesh, of which grid is the `meshes.kernels.distance.DistanceGrid`."""
    for i in prange(points.shape[0]):
        up = 0.0
        for _ in range(STEPS):
            away = distance(
                grid, points[i, 0] + up * normals[i, 0], points[i, 1] + up * normals[i, 1],
                points[i, 2] + up * normals[i, 2],
            )  # fmt: skip
            if away >= clear - ENOUGH:
                break
            up += clear - away
        out[i] = up


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
