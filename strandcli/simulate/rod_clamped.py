"""Tips that are clamped: pinned, along a direction that is given, with the frame that twist ends in.

What the compiled step does with it is in `kernels.rod_held`. The ends of all strands move as one thing in the emitter's
frame, by `rod.end_keys`, and each turns about its own direction.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..constants import FOLD
from .kernels.records import TIP_JOINT, TURN, Forcing, Material, State
from .kernels.rod_scratch import PACK
from .rod_pinned import Pins

if TYPE_CHECKING:
    from ..scene.model import Rod
    from ..scene.motion import Pose

Floats = NDArray[np.floating]


class Clamps(Pins):
    """Where tips are clamped: ``frames`` (P, 2, 3, `PACK`) their directions and the axes across these, in the emitter's
    frame as it is without keys."""

    def __init__(self, state: State, material: Material, forcing: Forcing, rod: Rod, pose: Pose) -> None:
        """Clamps tips where they are and along their last edges, with the emitter in a pose. The clamp's axis is where
        the strand's frame is at the start, so that nothing is twisted but what the rest shape is."""
        super().__init__(state, material, forcing, pose, rod.end_keys)
        forcing.numbers[TIP_JOINT] = 2 * rod.tip**4
        turn = np.array(pose.rotation)
        if state.twist.shape[1] > 1:
            state.twist[:, -1] = state.twist[:, -2]
        state.turned[...] = angle = state.twist[:, -1]
        t, a = last_frame(state, material, forcing, turn)
        axis = a * np.cos(angle) + np.cross(t, a, axis=0) * np.sin(angle)
        self.frames = np.einsum("ji,kjps->pkis", turn, np.stack([t, axis]))
        forcing.tips[...] = self.frames.reshape(forcing.tips.shape)

    def aim(self, state: State, forcing: Forcing, poses: tuple[Pose, Pose], time: float, dt: float) -> None:
        """As for pins, and set the directions and angles of the step's end."""
        super().aim(state, forcing, poses, time, dt)
        moved, turns = self.moved(time)
        turn = np.array(poses[1].rotation) @ np.array(moved.rotation)
        forcing.tips[...] = np.einsum("ij,pkjs->pkis", turn, self.frames).reshape(forcing.tips.shape)
        forcing.numbers[TURN] = 2 * math.pi * turns


def last_frame(state: State, material: Material, forcing: Forcing, turn: Floats) -> tuple[Floats, Floats]:
    """Return the last edge and the normal that is transported to it from the clamp of the root, (3, P, `PACK`) in the
    world, where the emitter is turned so."""
    edges = state.edges.reshape(*state.edges.shape[:2], 3, PACK).transpose(1, 2, 0, 3).astype(np.float64)
    bends = material.bends.reshape(*material.bends.shape[:2], 3, PACK)
    t = np.einsum("ij,pjk->ipk", turn, forcing.directions.reshape(-1, 3, PACK))
    a = np.einsum("ij,pjk->ipk", turn, bends[:, 0])
    for e in edges:
        a = a - (a * e).sum(0) / np.maximum(1 + (t * e).sum(0), FOLD) * (t + e)
        a /= np.sqrt((a * a).sum(0))
        t = e
    return t, a


def pins_of(state: State, material: Material, forcing: Forcing, rod: Rod, pose: Pose) -> Pins | None:
    """Return what holds the tips, where a preset asks for it."""
    if rod.end == "clamped":
        return Clamps(state, material, forcing, rod, pose)
    return Pins(state, material, forcing, pose, rod.end_keys) if rod.end == "pinned" else None
