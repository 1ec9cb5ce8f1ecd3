"""What takes long to make of a mesh, and is kept from one run to the next."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kept import FREE, Arrays, kept
from ..meshes.bvh import Bvh, make_bvh
from ..meshes.distance_grid import DistanceGrid, make_distance_grid
from ..meshes.mesh import TriangleMesh

TREE, GRID = ("strandcli.meshes.bvh",), ("strandcli.meshes.distance_grid",)
"""Modules that make them."""


def tree_of(mesh: TriangleMesh) -> Bvh:
    """The tree over a mesh's triangles."""
    count = len(mesh.triangles)
    like: Arrays = {
        FREE + "boxes": np.empty(0, np.float32), FREE + "child": np.empty(0, np.int32),
        FREE + "counts": np.empty(0, np.int32), "corners": np.empty((count, 3, 3)),
        "triangle": np.empty(count, np.int32), FREE + "moments": np.empty(0),
    }  # fmt: skip
    found = kept("tree", TREE, (mesh.vertices, mesh.triangles), like, lambda: make_bvh(mesh.vertices, mesh.triangles))
    boxes, child, counts, corners, triangle, moments = found
    return Bvh(boxes.reshape(-1, 6), child, counts, corners, triangle, moments.reshape(len(child), -1))


def distances_of(bvh: Bvh, closed: bool, resolution: int) -> DistanceGrid:
    """The grid of distances from a mesh, as `make_distance_grid`."""
    like: Arrays = {
        FREE + "values": np.empty(0, np.float32), "size": np.empty(3, np.int64), "low": np.empty(3, np.float32),
        "spacing": np.empty(1, np.float32),
    }  # fmt: skip

    def make() -> Iterable[NDArray[Any]]:
        values, low, spacing = make_distance_grid(bvh, closed, resolution)
        return values, np.array(values.shape), low, np.array([spacing])

    values, size, low, spacing = kept("grid", GRID, (*bvh, bool(closed), resolution), like, make)
    return DistanceGrid(values.reshape(size), low, spacing[0])
