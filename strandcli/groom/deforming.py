"""Roots on a mesh that deforms: they stay where they stand on their triangles, and turn with them; and roots of a file
that moves: they stand where it has them, and turn as its strands do there."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..scene.motion import deforming_ground, pose_in_emitter
from .record import Groom

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .record import Groom

Floats = NDArray[np.float64]
FLAT = 1e-6
"""Of the greatest extent, the second one below which points lie on a line, and tell no turn about it."""
EXACT = 1e-9
"""Frames that a time may be off a frame."""


class FileRoots:
    """The roots of a groom (n strands) whose `film` is the moments of a file and the rows (n,) of its strands there.

    A root turns as all roots and first segments do together, as a rigid body, and then by the least angle into its own
    first segment's direction. Between frames roots and segments move in straight lines.
    """

    def __init__(self, scene: Scene, groom: Groom) -> None:
        """``groom``: as it is at the start."""
        self._time, self._directions = scene.time, groom.directions.astype(np.float64)
        self._film, self._rows = groom.film
        self._start = self._ends(0.0)

    def at(self, time: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return roots (n, 3), metres, and unit directions (n, 3) at a time in seconds, in the emitter's frame."""
        ends = self._ends(time)
        directions = np.einsum("nij,nj->ni", self._turns(ends), self._directions)
        return ends[self._rows, 0].astype(np.float32), directions.astype(np.float32)

    def roots(self, time: float) -> Floats:
        """Return roots (n, 3), metres, at a time in seconds, in the emitter's frame."""
        return self._ends(time)[self._rows, 0]

    def turns(self, time: float) -> Floats:
        """Return the rotations (n, 3, 3) of roots from the start to a time in seconds, in the emitter's frame."""
        return self._turns(self._ends(time))

    def _ends(self, time: float) -> Floats:
        """Return the first two points (S, 2, 3) of all strands at a time in seconds."""
        frame = self._time.pose_time(time) * self._time.fps
        first = math.floor(frame + EXACT)
        found = self._film.ends(first / self._time.fps, self._time.fps)
        if frame - first <= EXACT:
            return np.asarray(found)
        after = self._film.ends((first + 1) / self._time.fps, self._time.fps)
        return np.asarray(found + (frame - first) * (after - found))

    def _turns(self, ends: Floats) -> Floats:
        whole = rigid(self._start.reshape(-1, 3), ends.reshape(-1, 3))
        before, after = (units(one[self._rows, 1] - one[self._rows, 0]) for one in (self._start, ends))
        return least_turns(before @ whole.T, after) @ whole


def rigid(first: Floats, second: Floats) -> Floats:
    """Return the rotation (3, 3) that takes points (k, 3) to their targets best (Kabsch 1976), not all on a line."""
    a, b = first - first.mean(axis=0), second - second.mean(axis=0)
    u, extents, v = np.linalg.svd(b.T @ a)
    if extents[1] <= FLAT * extents[0]:
        return np.eye(3)
    mirrored = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))])
    return np.asarray(u @ mirrored @ v)


def least_turns(first: Floats, second: Floats) -> Floats:
    """Return the rotations (n, 3, 3) by the least angles that take unit vectors (n, 3) to their targets; half a turn
    about any axis across where they are opposite."""
    total = first + second
    back = np.einsum("ni,ni->n", total, total) < EXACT
    x = np.abs(first[:, :1]) < 0.9
    across = units(np.cross(first, np.where(x, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])))
    middle = np.where(back[:, None], across, units(total))
    flip = 2 * np.einsum("ni,nj->nij", middle, middle) - np.eye(3)
    straight = 2 * np.einsum("ni,nj->nij", first, first) - np.eye(3)
    turns = flip @ straight
    return np.asarray(np.where(back[:, None, None], flip, turns))


def units(vectors: Floats) -> Floats:
    """Return unit vectors (n, 3); +y where there is no direction."""
    sizes = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(sizes > 0, vectors / np.where(sizes > 0, sizes, 1.0), np.array([0.0, 1.0, 0.0]))


class Deforming:
    """The roots of a groom on a mesh that deforms: the emitter's, or the solid that strands of a file are put on."""

    def __init__(self, scene: Scene, groom: Groom, emitted: bool = False) -> None:
        """``groom``: as it is at the start, or where ``emitted`` is true as on the mesh of `emitter.shape.file`."""
        from ..mesh_file.read import placed, placing

        self._ground = deforming_ground(scene)
        assert groom.anchors is not None
        self.scene = scene
        self.anchors = groom.anchors
        mesh = placed(self._ground.file, placing(self._ground))
        self._pose = None if scene.emitter.groom is None else pose_in_emitter(self._ground, scene.emitter)
        self._triangles = mesh.triangles[groom.anchors.triangles]
        first = mesh.vertices[self._triangles] if emitted else self._corners(0.0)
        self._own = np.einsum("nck,nc->nk", frames(first), groom.directions.astype(np.float64))
        """(n, 3) directions in the frames of their triangles."""
        self._start = frames(first)
        self._off: Floats | None = None
        """(n, 3) metres, where roots stand off the mesh, in the frames of their triangles; None: nowhere."""
        if self._pose is not None:
            off = groom.roots - np.einsum("nk,nkc->nc", self.anchors.shares, first)
            self._off = np.einsum("nck,nc->nk", self._start, off)

    def at(self, time: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return roots (n, 3), metres, and unit directions (n, 3) at a time in seconds, in the emitter's frame."""
        corners = self._corners(time)
        roots = self._at(corners)
        directions = np.einsum("nck,nk->nc", frames(corners), self._own)
        return roots.astype(np.float32), directions.astype(np.float32)

    def roots(self, time: float) -> Floats:
        """Return roots (n, 3), metres, at a time in seconds, in the emitter's frame."""
        return self._at(self._corners(time))

    def turns(self, time: float) -> Floats:
        """Return the rotations (n, 3, 3) of triangles from the start to a time in seconds, in the emitter's frame."""
        return np.asarray(np.einsum("nck,ndk->ncd", frames(self._corners(time)), self._start))

    def _at(self, corners: Floats) -> Floats:
        """Return roots (n, 3) on triangles (n, 3, 3)."""
        roots = np.asarray(np.einsum("nk,nkc->nc", self.anchors.shares, corners))
        return roots if self._off is None else roots + np.einsum("nck,nk->nc", frames(corners), self._off)

    def _corners(self, time: float) -> Floats:
        from ..mesh_file.read import vertices_at

        vertices = vertices_at(self._ground, self.scene.time.pose_time(time))
        if self._pose is not None:
            vertices = vertices @ np.array(self._pose.rotation).T + np.array(self._pose.translation)
        found: Floats = vertices[self._triangles]
        return found


def frames(corners: Floats) -> Floats:
    """Return the frames (n, 3, 3) of triangles (n, 3, 3), whose columns are unit vectors: along the first edge, across
    it in the plane, and the normal."""
    edge = corners[:, 1] - corners[:, 0]
    edge = edge / np.maximum(np.linalg.norm(edge, axis=1), 1e-300)[:, None]
    normal = np.cross(edge, corners[:, 2] - corners[:, 0])
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    return np.stack([edge, np.cross(normal, edge), normal], axis=2)


def deforming(scene: Scene, groom: Groom) -> Deforming | FileRoots | None:
    """Return the moving roots of a groom, None where they do not move in the emitter's frame."""
    carried = any(use.name == "emitter_motion" for use in scene.rules)
    if carried and scene.emitter.followers is not None and groom.film is not None:
        return FileRoots(scene, groom)
    return Deforming(scene, groom) if carried and deforming_ground(scene) is not None else None


def at_start(scene: Scene, groom: Groom) -> Groom:
    """Return a groom with roots and directions as they are at the start."""
    if deforming_ground(scene) is None:
        return groom
    roots, directions = Deforming(scene, groom, emitted=True).at(0.0)
    return replace(groom, roots=roots, directions=directions)
