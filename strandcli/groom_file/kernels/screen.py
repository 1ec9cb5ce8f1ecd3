"""Distances of many points from a mesh by its grid."""

from __future__ import annotations

from ...jit import parallel, prange
from ...meshes.kernels.distance import distance


@parallel
def grid_distances(grid, points, out):
    """Write the signed distances of points (n, 3) to out (n,); outside of the grid a lower bound."""
    for i in prange(points.shape[0]):
        out[i] = distance(grid, points[i, 0], points[i, 1], points[i, 2])
