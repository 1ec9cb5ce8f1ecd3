"""Surfaces of solids that hair of a file is put on: the nearest point of each to others."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..mesh_file.prepared import key_of, mesh_of, prepared
from ..meshes.bvh import closest
from .kernels.screen import grid_distances

Floats = NDArray[np.float64]

PLANE = 1.0
"""Metres that a plane counts as large."""
AT_ONCE = 1 << 20
"""Points that are looked at at once."""


class Near(NamedTuple):
    """Of points (n): the nearest ones of a surface (n, 3), signed distances (n,), negative inside, and unit vectors
    (n, 3) along which the distance grows."""

    points: Floats
    distances: Floats
    outward: Floats


class Surface:
    """The surface of a solid at the start, in its own frame, metres. ``size``: the longest side of its box."""

    def __init__(self, solid: Any) -> None:
        self.solid = solid
        if solid.kind == "mesh":
            self.mesh = prepared(key_of(solid, 0.0))
            self.size = mesh_of(solid).size()
        else:
            self.size = {
                "sphere": lambda: 2 * solid.radius,
                "capsule": lambda: 2 * solid.radius + solid.length,
                "box": lambda: max(solid.size),
                "plane": lambda: PLANE,
            }[solid.kind]()

    def nearest(self, points: Floats) -> Near:
        """Return the nearest points of the surface to points (n, 3)."""
        if self.solid.kind != "mesh":
            return FORMS[self.solid.kind](self.solid, points)
        found = closest(self.mesh.bvh, points)
        away = (points - found.points) / np.where(found.distances == 0, 1.0, found.distances)[:, None]
        faces = self.mesh.faces[found.triangles]
        on = np.abs(found.distances) < 1e-6 * self.size
        return Near(found.points, found.distances, np.where(on[:, None], faces, away))

    def least(self, points: Floats) -> NDArray[np.floating]:
        """Return (n,) numbers that are hardly above the distances of points (n, 3), quickly."""
        if self.solid.kind != "mesh":
            return FORMS[self.solid.kind](self.solid, points).distances
        found = np.empty(len(points), np.float32)
        grid_distances(self.mesh.grid, points, found)
        return np.asarray(found - self.mesh.grid.spacing)


def _sphere(solid: Any, points: Floats) -> Near:
    return _round(points, np.zeros_like(points), solid.radius)


def _capsule(solid: Any, points: Floats) -> Near:
    axis = np.zeros_like(points)
    axis[:, 1] = np.clip(points[:, 1], -0.5 * solid.length, 0.5 * solid.length)
    return _round(points, axis, solid.radius)


def _round(points: Floats, middles: Floats, radius: float) -> Near:
    """All within a radius of middles (n, 3)."""
    away = points - middles
    size = np.linalg.norm(away, axis=1)
    outward = np.where(size[:, None] > 0, away / np.where(size > 0, size, 1.0)[:, None], np.array([1.0, 0.0, 0.0]))
    return Near(middles + radius * outward, size - radius, outward)


def _plane(solid: Any, points: Floats) -> Near:
    outward = np.broadcast_to(np.array([0.0, 1.0, 0.0]), points.shape)
    return Near(points * [1.0, 0.0, 1.0], points[:, 1].copy(), outward)


def _box(solid: Any, points: Floats) -> Near:
    half = 0.5 * np.array(solid.size)
    near = np.clip(points, -half, half)
    distances = np.linalg.norm(points - near, axis=1)
    outward = (points - near) / np.where(distances > 0, distances, 1.0)[:, None]
    inside = np.flatnonzero(distances == 0)
    room = half - np.abs(points[inside])
    axis = np.argmin(room, axis=1)
    side = np.where(points[inside, axis] < 0, -1.0, 1.0)
    near[inside, axis] = side * half[axis]
    distances[inside] = -room[np.arange(len(inside)), axis]
    outward[inside] = 0.0
    outward[inside, axis] = side
    return Near(near, distances, outward)


FORMS = {"sphere": _sphere, "capsule": _capsule, "plane": _plane, "box": _box}
