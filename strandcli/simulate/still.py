"""The solver of strands from a file: they move as the file says and rigidly with their emitter, or each with its
triangle of a mesh that deforms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from ..groom.blocks import lanes, pack
from ..groom.deforming import Deforming, FileRoots, deforming
from ..groom.record import Groom
from ..scene.motion import Pose, emitter_pose
from .solver import Solver

if TYPE_CHECKING:
    from ..scene.model import Scene

IDENTITY = Pose(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))


class StillSolver(Solver):
    """Strands whose points are given; with the emitter at the origin, they keep their bits. ``lengths`` are mean
    segment lengths."""

    independent = True

    def __init__(self, scene: Scene, groom: Groom) -> None:
        assert groom.points is not None
        self.scene = scene
        self.groom = self._first = groom
        self.strands = groom.strands
        self.given = groom.points
        self.positions = groom.points
        self.lengths = lanes(groom.lengths[:, None] / np.float32(groom.points.shape[1] - 2))
        self._carried = any(use.name == "emitter_motion" for use in scene.rules)
        self.deforming = deforming(scene, groom)
        self._pose = IDENTITY
        self.advance(1)

    def step(self, time: float, dt: float) -> None:
        """Do nothing: strands have no motion of their own."""

    def advance(self, frame: int) -> None:
        """Set the positions of all strands at a frame."""
        time = self.scene.time.pose_time((frame - 1) / self.scene.time.fps)
        pose = emitter_pose(self.scene.emitter, time if self._carried else 0.0)
        if self._first.film is not None:
            self._show(time)
        if self.deforming is not None:
            self._deform(self.deforming, (frame - 1) / self.scene.time.fps, pose)
            return
        if pose == self._pose:
            return
        self._own_positions()
        turn, shift = np.array(pose.rotation), np.array(pose.translation)
        for block, out in zip(self.given, self.positions, strict=True):
            moved = np.einsum("ij,rjk->rik", turn, block.reshape(-1, 3, W)) + shift[:, None]
            out.reshape(-1, 3, W)[...] = moved
        self._pose = pose

    place_roots = advance

    def _show(self, time: float) -> None:
        """Set the strands to what the file has at a time."""
        self.given, groom = self._first.film.at(time, self.scene.time.fps, self._first)
        self.positions, self._pose = self.given, IDENTITY
        if groom is not self.groom:
            self.groom, self.strands = groom, groom.strands
            self.lengths = lanes(groom.lengths[:, None] / np.float32(self.given.shape[1] - 2))

    def _own_positions(self) -> None:
        if self.positions is self.given:
            self.positions = np.empty_like(self.given)

    def _deform(self, roots: Deforming | FileRoots, at: float, pose: Pose) -> None:
        """Set the positions of all strands, each of which moves rigidly with its triangle and then with the emitter."""
        self._own_positions()
        outer, shift = np.array(pose.rotation), np.array(pose.translation)
        turns = np.einsum("ij,njk->nik", outer, roots.turns(at))
        shifts = roots.roots(at) @ outer.T + shift - np.einsum("nij,nj->ni", turns, self.groom.roots)
        rows = np.minimum(np.arange(len(self.given) * W), self.strands - 1).reshape(-1, W)
        for block, out, some in zip(self.given, self.positions, rows, strict=True):
            moved = np.einsum("kij,rjk->rik", turns[some], block.reshape(-1, 3, W)) + shifts[some].T
            out.reshape(-1, 3, W)[...] = moved

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return nothing: a frame does not depend on those before it."""
        return {}

    def take(self, frame: int, particles: NDArray[np.floating]) -> None:
        """Set the particles of a frame, (strands or more, particles, 3) metres."""
        rows = self.groom.placed(particles[: self.strands])
        before = 2 * rows[:, :1] - rows[:, 1:2]
        self.positions = pack(np.concatenate([before, rows], axis=1))

    def errors(self, frame: int) -> dict[str, float | None]:
        """Return errors without any but numbers of the file that are not finite: nothing is simulated."""
        return {
            "stretch_max": 0.0,
            "penetration_max": None,
            "segment_penetration_max": None,
            "residual_max": None,
            "nonfinite": 0 if self._first.film is None else int(np.count_nonzero(~np.isfinite(self.positions))),
        }
