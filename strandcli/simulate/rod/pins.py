"""Tips that are pinned: hinges about places that the emitter carries along.

A pinned particle weighs so much that nothing moves it, and its free displacement is the way to its place.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...scene.motion import Pose
from .kernels.arrays import PACK, Drive, Material, State

HEAVY = 1e6
"""Factor of a pinned particle's mass."""
TOLERANCE = 1e-6
"""Error of |e|² at which iterations stop, in single precision: what is left moves tips off their places."""


def tips(state: State) -> NDArray[np.float64]:
    """(P, 3, `PACK`) where the last particles of strands are, metres."""
    rows = state.positions[:, -1].reshape(-1, 3, W // PACK, PACK).transpose(0, 2, 1, 3).reshape(-1, 3, PACK)
    return np.asarray(rows[: len(state.edges)], np.float64)


class Pins:
    """Where tips are pinned: ``places`` (P, 3, `PACK`) metres in the emitter's frame."""

    def __init__(self, state: State, material: Material, drive: Drive, pose: Pose) -> None:
        """Pins tips where they are, with the emitter in a pose."""
        self._lengths = material.lengths
        self._longest = material.lengths.astype(np.float64) * state.edges.shape[1]
        away = self._ends(state, drive, pose) - np.array(pose.translation)[:, None]
        self.places = np.einsum("ji,pjk->pik", np.array(pose.rotation), away)
        self._starts, self._seconds = self.places, 0.0

    def bring(self, place: tuple[float, float, float], seconds: float) -> None:
        """Bring all tips to a place of the emitter's frame, metres, in so many seconds."""
        self.places, self._seconds = np.broadcast_to(np.array(place)[:, None], self._starts.shape), seconds

    def aim(self, state: State, drive: Drive, poses: tuple[Pose, Pose], time: float) -> None:
        """Set `Drive.tips` to the way to where tips are to be at the end of a step at ``time``, with the emitter in two
        ``poses``, at the begin and the end."""
        share = min(max(time, 0.0) / self._seconds, 1.0) if self._seconds > 0 else 1.0
        local = self._starts + share * (self.places - self._starts)
        pose = poses[1]
        goals = np.einsum("ij,pjk->pik", np.array(pose.rotation), local) + np.array(pose.translation)[:, None]
        roots = self._roots(drive, pose)
        far, most = np.linalg.norm(goals - roots, axis=1), self._longest
        # no iteration finds lengths for a place out of reach, nor with slack for a taut strand that is shaken
        goals = roots + (goals - roots) * np.minimum(1, most / np.maximum(far, most))[:, None]
        drive.tips[...] = (goals - self._ends(state, drive, poses[0])).reshape(drive.tips.shape)

    def _ends(self, state: State, drive: Drive, pose: Pose) -> NDArray[np.float64]:
        """Return (P, 3, `PACK`) where edges lead from roots. Positions are rounded more far from the origin, and a taut
        strand has no way to go by that."""
        edges = state.edges.sum(1, dtype=np.float64).reshape(len(state.edges), 3, PACK)
        return self._roots(drive, pose) + edges * self._lengths[:, None]

    @staticmethod
    def _roots(drive: Drive, pose: Pose) -> NDArray[np.float64]:
        """Return (P, 3, `PACK`) roots, with the emitter in a pose."""
        roots = drive.roots.reshape(len(drive.roots), 3, PACK).astype(np.float64)
        return np.einsum("ij,pjk->pik", np.array(pose.rotation), roots) + np.array(pose.translation)[:, None]
