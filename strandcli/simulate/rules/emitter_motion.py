"""Emitter motion: p_0' = p_0 + Δemitter (thesis §2), turned as well as moved.

Roots are placed from the emitter's own frame, so nothing drifts however long the animation. It acts on the root before
any rule acts on the particles after it, wherever the preset lists it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ...constants import W
from ...scene.motion import emitter_pose, roots_move
from .rule import Moment, Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

name = "emitter_motion"
order = 0.0
ROW_X, ROW_Y, ROW_Z, SHIFT = 0, 3, 6, 9
"""Where the rows of the rotation begin in p, and the translation, metres."""


@dataclass(frozen=True, slots=True)
class Parameters:
    """The motion is the emitter's own: its keys."""


def apply(clamp: Any, root: Any, rest_clamp: Any, rest_root: Any, p: Any) -> None:
    """Write a strand's root and the row before it from their positions in the emitter's frame; p: columns above."""
    for out, rest in ((root, rest_root), (clamp, rest_clamp)):
        for k in range(W):
            x, y, z = rest[k], rest[W + k], rest[2 * W + k]
            out[k] = p[ROW_X] * x + p[ROW_X + 1] * y + p[ROW_X + 2] * z + p[SHIFT]
            out[W + k] = p[ROW_Y] * x + p[ROW_Y + 1] * y + p[ROW_Y + 2] * z + p[SHIFT + 1]
            out[2 * W + k] = p[ROW_Z] * x + p[ROW_Z + 1] * y + p[ROW_Z + 2] * z + p[SHIFT + 2]


def idle(parameters: Parameters, scene: Scene) -> str:
    """Why this rule has nothing to do, or nothing."""
    if len(scene.emitter.keys) > 1 or roots_move(scene):
        return ""
    return "the emitter has fewer than two keys: it never moves"


def passes(parameters: Parameters, scene: Scene) -> list[Pass]:
    """One pass."""

    def prepare(moment: Moment) -> Any:
        import numpy as np

        (a, b, c), translation = emitter_pose(moment.scene.emitter, moment.pose_time)
        return np.array([*a, *b, *c, *translation], np.float32)

    return [Pass(apply, prepare, stage="root")]
