"""Tips that are pinned: hinges about places that the emitter carries along.

A pinned particle weighs so much that nothing moves it, and what it has before a step is the velocity that leads to its
place. So the compiled step knows of no pins, and strands without them are stepped as ever.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from ..scene.motion import Pose
from .kernels.records import AIR, CHANGED, DRAG, GRAVITY, LASTING, STEP, VELOCITY_STEP, Forcing, Material, State
from .kernels.rod_scratch import PACK

TOLERANCE = 1e-6
"""Error of |e|² at which iterations stop, in single precision: what is left moves tips off their places."""


def tips(state: State) -> NDArray[np.float64]:
    """(P, 3, `PACK`) where the last particles of strands are, metres."""
    rows = state.positions[:, -1].reshape(-1, 3, W // PACK, PACK).transpose(0, 2, 1, 3).reshape(-1, 3, PACK)
    return np.asarray(rows[: len(state.edges)], np.float64)


class Pins:
    """Where tips are pinned: ``places`` (P, 3, `PACK`) metres in the emitter's frame."""

    def __init__(self, state: State, material: Material, forcing: Forcing, pose: Pose) -> None:
        """Pins tips where they are, with the emitter in a pose."""
        self._lengths = material.lengths
        self._longest = material.lengths.astype(np.float64) * state.edges.shape[1]
        away = self._ends(state, forcing, pose) - np.array(pose.translation)[:, None]
        self.places = np.einsum("ji,pjk->pik", np.array(pose.rotation), away)
        self._starts, self._seconds = self.places, 0.0

    def bring(self, place: tuple[float, float, float], seconds: float) -> None:
        """Bring all tips to a place of the emitter's frame, metres, in so many seconds."""
        self.places, self._seconds = np.broadcast_to(np.array(place)[:, None], self._starts.shape), seconds

    def aim(self, state: State, forcing: Forcing, poses: tuple[Pose, Pose], time: float, dt: float) -> None:
        """Give tips the velocity that leads to their places at the end of a step of ``dt`` seconds at ``time``, with
        the emitter in two ``poses``, at the begin and the end. `kernels.rod_start` predicts u* = h / (1 + γ g) (v + g
        (gravity + γ wind)), with the rate γ of drag: solved for v, where u* is the way to go."""
        share = min(max(time, 0.0) / self._seconds, 1.0) if self._seconds > 0 else 1.0
        local = self._starts + share * (self.places - self._starts)
        pose = poses[1]
        goals = np.einsum("ij,pjk->pik", np.array(pose.rotation), local) + np.array(pose.translation)[:, None]
        roots = self._roots(forcing, pose)
        far, most = np.linalg.norm(goals - roots, axis=1), self._longest
        # no iteration finds lengths for a place out of reach, nor with slack for a taut strand that is shaken
        goals = roots + (goals - roots) * np.minimum(1, most / np.maximum(far, most))[:, None]
        way = goals - self._ends(state, forcing, poses[0])
        numbers = forcing.numbers.astype(np.float64)
        h, g, drag = numbers[STEP], numbers[VELOCITY_STEP], numbers[DRAG]  # h_x, h_v and γ of docs/solvers.md
        for marks, least in self._marks(state, forcing):
            if len(marks) == len(way):
                marked = marks[:, None] > least
                h, g = np.where(marked, dt, h), np.where(marked, dt, g)
        air = drag * forcing.gust[:, None] * numbers[AIR : AIR + 3, None]
        velocity = way * (1 + drag * g) / h - g * (numbers[GRAVITY : GRAVITY + 3, None] + air)
        for member in (state.velocity, state.ahead):  # arrays that a scene does not need are empty
            if len(member) == len(way):
                member[:, -1] = velocity.reshape(len(way), -1)
        for member in (state.moved, state.push, state.crowd):
            if len(member) == len(way):
                member[:, -1] = 0

    @staticmethod
    def _marks(state: State, forcing: Forcing) -> tuple[tuple[NDArray[np.floating], float], ...]:
        """Return arrays (P, S) of the state and above which value each has a strand take the step by Euler's method, as
        `kernels.rod_start.disturbed` does; those that a scene does not need are empty."""
        pressed = 0.0 if forcing.numbers[LASTING] > 0 else 0.5 * CHANGED
        return (state.jolted, 0.0), (state.touching, pressed), (state.calmed, 0.0)

    def _ends(self, state: State, forcing: Forcing, pose: Pose) -> NDArray[np.float64]:
        """Return (P, 3, `PACK`) where edges lead from roots. Positions are rounded more far from the origin, and a taut
        strand has no way to go by that."""
        edges = state.edges.sum(1, dtype=np.float64).reshape(len(state.edges), 3, PACK)
        return self._roots(forcing, pose) + edges * self._lengths[:, None]

    @staticmethod
    def _roots(forcing: Forcing, pose: Pose) -> NDArray[np.float64]:
        """Return (P, 3, `PACK`) roots, with the emitter in a pose."""
        roots = forcing.roots.reshape(len(forcing.roots), 3, PACK).astype(np.float64)
        return np.einsum("ij,pjk->pik", np.array(pose.rotation), roots) + np.array(pose.translation)[:, None]
