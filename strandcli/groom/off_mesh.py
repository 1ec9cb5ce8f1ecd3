"""Points moved out of the mesh that strands grow on, for ties: combed strands lie on it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..mesh_file.prepared import distances
from ..mesh_file.read import placing
from ..scene.model import MeshShape

Floats = NDArray[np.float64]

RESOLUTION = 128
"""Nodes along the longest side of the grid of distances from the mesh."""
CLEAR = 0.1
"""Distance from the mesh, in cells of that grid, that counts as outside: several times its error."""


def rise(shape: MeshShape, points: Floats, normals: Floats) -> Floats:
    """Return (N,) how far points (N, 3), metres in the emitter's frame, must move along unit normals (N, 3) to be
    outside of a mesh. Raises `UsageError` for a mesh that cannot be read."""
    from .kernels.combed import lift_off_mesh

    grid = distances(shape.file, placing(shape), RESOLUTION)
    out = np.empty(len(points))
    lift_off_mesh(np.ascontiguousarray(points), np.ascontiguousarray(normals), grid, CLEAR * float(grid.spacing), out)
    return out
