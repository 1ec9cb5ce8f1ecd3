"""Roots on a mesh that deforms: they stay where they stand on their triangles, and turn with them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..scene.model import MeshShape
from ..scene.motion import roots_deform
from .record import Groom

if TYPE_CHECKING:
    from ..scene.model import Scene

Floats = NDArray[np.float64]


class Deforming:
    """The roots of a groom on a mesh that deforms."""

    def __init__(self, scene: Scene, groom: Groom, emitted: bool = False) -> None:
        """``groom``: as it is at the start, or where ``emitted`` is true as on the mesh of `emitter.shape.file`."""
        from .on_mesh import seedbed

        shape = scene.emitter.shape
        assert isinstance(shape, MeshShape)
        assert groom.anchors is not None
        self.scene = scene
        self.anchors = groom.anchors
        mesh = seedbed(shape).mesh
        self._triangles = mesh.triangles[groom.anchors.triangles]
        first = mesh.vertices[self._triangles] if emitted else self._corners(0.0)
        self._own = np.einsum("nck,nc->nk", frames(first), groom.directions.astype(np.float64))
        """(n, 3) directions in the frames of their triangles."""

    def at(self, time: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return roots (n, 3), metres, and unit directions (n, 3) at a time in seconds, in the emitter's frame."""
        corners = self._corners(time)
        roots = np.einsum("nk,nkc->nc", self.anchors.shares, corners)
        directions = np.einsum("nck,nk->nc", frames(corners), self._own)
        return roots.astype(np.float32), directions.astype(np.float32)

    def roots(self, time: float) -> Floats:
        """Return roots (n, 3), metres, at a time in seconds, in the emitter's frame."""
        return np.asarray(np.einsum("nk,nkc->nc", self.anchors.shares, self._corners(time)))

    def _corners(self, time: float) -> Floats:
        from ..mesh_file.read import vertices_at

        found: Floats = vertices_at(self.scene.emitter.shape, self.scene.time.pose_time(time))[self._triangles]
        return found


def frames(corners: Floats) -> Floats:
    """Return the frames (n, 3, 3) of triangles (n, 3, 3), whose columns are unit vectors: along the first edge, across
    it in the plane, and the normal."""
    edge = corners[:, 1] - corners[:, 0]
    edge = edge / np.maximum(np.linalg.norm(edge, axis=1), 1e-300)[:, None]
    normal = np.cross(edge, corners[:, 2] - corners[:, 0])
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    return np.stack([edge, np.cross(normal, edge), normal], axis=2)


def deforming(scene: Scene, groom: Groom) -> Deforming | None:
    """Return the moving roots of a groom, None where they do not move in the emitter's frame."""
    carried = any(use.name == "emitter_motion" for use in scene.rules)
    return Deforming(scene, groom) if carried and roots_deform(scene.emitter) else None


def at_start(scene: Scene, groom: Groom) -> Groom:
    """Return a groom with roots and directions as they are at the start."""
    if not roots_deform(scene.emitter):
        return groom
    roots, directions = Deforming(scene, groom, emitted=True).at(0.0)
    return replace(groom, roots=roots, directions=directions)
