"""A tree over the triangles of a mesh, for rays, nearest points and winding numbers, and signed distances on a grid.

When vertices move, `moved` is much faster than a new tree, and as good while the mesh deforms gently.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .kernels.distance import DistanceGrid
from .kernels.nearest import closest as _closest
from .kernels.packets import (
    AB,
    BC,
    CA,
    IN_AB,
    IN_BC,
    IN_CA,
    NORMAL,
    ROW,
    SHORT,
    SIDE,
    A,
    PacketTree,
    fill,
)  # fmt: skip
from .kernels.tree import BINS, Bvh, build, refit
from .kernels.winding import moments

__all__ = ["Bvh", "DistanceGrid", "make_bvh", "make_distance_grid", "moved"]

TASKS = 128
"""Nodes that wait to be made, at most: one a level of depth."""


def make_bvh(vertices: npt.NDArray[Any], triangles: npt.NDArray[Any]) -> Bvh:
    """A tree over triangles: vertices (V, 3), triangles (T, 3), at least one."""
    corners = np.ascontiguousarray(vertices, np.float64)[triangles]
    count = corners.shape[0]
    boxes = _boxes(corners)
    order = np.arange(count, dtype=np.int32)
    whole = Bvh(
        np.empty((2 * count - 1, 6), np.float32), np.empty(2 * count - 1, np.int32), np.empty(2 * count - 1, np.int32),
        corners, order, np.empty((1, 8)),
    )  # fmt: skip
    scratch = np.empty(count, np.int32)
    tasks, bins = np.empty((TASKS, 5), np.int32), np.empty((2 * BINS + 2, 6), np.float32)
    nodes = build(boxes, order, scratch, whole, tasks, bins, np.empty(2 * BINS, np.int32))
    bvh = Bvh(
        whole.boxes[:nodes].copy(), whole.child[:nodes].copy(), whole.counts[:nodes].copy(),
        corners[order], order, np.empty((nodes, 8)),
    )  # fmt: skip
    moments(bvh)
    return bvh


def moved(bvh: Bvh, vertices: npt.NDArray[Any], triangles: npt.NDArray[Any]) -> Bvh:
    """The tree of the same triangles with their vertices elsewhere."""
    corners = np.ascontiguousarray(vertices, np.float64)[triangles[bvh.triangle]]
    found = bvh._replace(boxes=np.empty_like(bvh.boxes), corners=corners, moments=np.empty_like(bvh.moments))
    refit(_boxes(corners), found)
    moments(found)
    return found


def _boxes(corners: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """Boxes (T, 6) of triangles, rounded outward to single precision."""
    found = np.empty((corners.shape[0], 6), np.float32)
    found[:, :3] = np.nextafter(corners.min(axis=1).astype(np.float32), np.float32(-np.inf))
    found[:, 3:] = np.nextafter(corners.max(axis=1).astype(np.float32), np.float32(np.inf))
    return found


class Closest(NamedTuple):
    """Of each point (P of them) the nearest one of a mesh.

    points: (P, 3) float64; triangles: (P,) int32, numbers in the mesh; barycentrics: (P, 3) float64, shares of the
    triangle's three corners; distances: (P,) float64, negative inside.
    """

    points: npt.NDArray[np.float64]
    triangles: npt.NDArray[np.int32]
    barycentrics: npt.NDArray[np.float64]
    distances: npt.NDArray[np.float64]


def closest(bvh: Bvh, points: npt.NDArray[Any]) -> Closest:
    """The nearest points of a mesh; points: (P, 3), units of the mesh, finite."""
    given = np.ascontiguousarray(points, np.float64)
    count = given.shape[0]
    found = Closest(np.empty((count, 3)), np.empty(count, np.int32), np.empty((count, 3)), np.empty(count))
    _closest(bvh, given, *found)
    return found


MARGIN = 2
"""Cells between the mesh and the edge of the grid."""


def make_distance_grid(
    bvh: Bvh, closed: bool, resolution: int = 128,
    box: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]] | None = None,
) -> DistanceGrid:  # fmt: skip
    """Signed distances at nodes all around a mesh, negative inside: `resolution` nodes, at least 8, along its longest
    side, less along the rest.

    closed: whether the mesh has no boundary (`TriangleMesh.closed`); otherwise inside is where its winding number is
    over a half.
    box: low and high corner that take the place of the mesh's, so that meshes in motion have the same nodes.
    """
    low, high = box or (bvh.boxes[0, :3].astype(np.float64), bvh.boxes[0, 3:].astype(np.float64))
    counts, spacing = grid_nodes(low, high, resolution)
    middle = 0.5 * (low + high)
    first = -0.5 * spacing * (counts - 1)
    blocks = -(-counts // SIDE)
    lanes = np.empty((2, SIDE * SIDE), np.float32)
    lanes[0] = spacing * np.tile(np.arange(SIDE), SIDE)
    lanes[1] = spacing * np.repeat(np.arange(SIDE), SIDE)
    out = np.empty((blocks[1], blocks[0], counts[2], SIDE * SIDE), np.float32)
    fill(bvh, packet_tree(bvh, middle), lanes, first.astype(np.float32), middle, np.float32(spacing), closed, out)
    values = out.reshape(blocks[1], blocks[0], counts[2], SIDE, SIDE).transpose(2, 0, 3, 1, 4)
    values = values.reshape(counts[2], blocks[1] * SIDE, blocks[0] * SIDE)
    values = np.ascontiguousarray(values[:, : counts[1], : counts[0]])
    return DistanceGrid(values, (middle + first).astype(np.float32), np.float32(spacing))


def grid_nodes(
    low: npt.NDArray[np.float64], high: npt.NDArray[np.float64], resolution: int
) -> tuple[npt.NDArray[np.int64], float]:
    """Nodes (3,) along x, y and z of the grid of a mesh with these corners, and how far they are apart."""
    longest = float((high - low).max())
    wide = MARGIN * longest / (resolution - 1 - 2 * MARGIN)
    spacing = (longest + 2 * wide) / (resolution - 1)
    return np.ceil((high - low + 2 * wide) / spacing - 1e-6).astype(np.int64) + 1, spacing


def packet_tree(bvh: Bvh, middle: npt.NDArray[np.float64]) -> PacketTree:
    """A tree in single precision about a point."""
    boxes = np.empty_like(bvh.boxes)
    boxes[:, :3] = np.nextafter((bvh.boxes[:, :3] - middle).astype(np.float32), np.float32(-np.inf))
    boxes[:, 3:] = np.nextafter((bvh.boxes[:, 3:] - middle).astype(np.float32), np.float32(np.inf))
    return PacketTree(boxes, bvh.child, bvh.counts, _rows(bvh.corners - middle))


def _rows(corners: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """Rows of triangles; of those without area only the edges count."""
    rows = np.zeros((corners.shape[0], ROW), np.float32)
    edges = np.roll(corners, -1, axis=1) - corners
    normals = np.cross(edges[:, 0], -edges[:, 2])
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, size, out=np.zeros_like(normals), where=size > 0)
    squares = (edges * edges).sum(axis=2)
    rows[:, A : A + 3] = corners[:, 0]
    rows[:, NORMAL : NORMAL + 3] = normals
    rows[:, SHORT : SHORT + 3] = np.divide(1.0, squares, out=np.zeros_like(squares), where=squares > 0)
    for k, (edge, inward) in enumerate(((AB, IN_AB), (BC, IN_BC), (CA, IN_CA))):
        rows[:, edge : edge + 3] = edges[:, k]
        rows[:, inward : inward + 3] = np.cross(normals, edges[:, k])
    return rows
