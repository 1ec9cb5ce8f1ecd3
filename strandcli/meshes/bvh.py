"""A tree over the triangles of a mesh, for rays, nearest points and winding numbers.

    bvh = make_bvh(mesh.vertices, mesh.triangles)

Kernels call `kernels.rays.first_hit`, `kernels.rays.any_hit`, `kernels.nearest.nearest` and `kernels.winding.winding`
with it. When vertices move, `moved(bvh, vertices, triangles)` is much faster than a new tree, and as good while the
mesh deforms gently. `closest` finds the points of the mesh that are nearest to others.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .kernels.nearest import closest as _closest
from .kernels.tree import BINS, Bvh, build, refit
from .kernels.winding import moments

__all__ = ["Bvh", "make_bvh", "moved"]

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
