"""Emitter motion: p_0' = p_0 + Δemitter (thesis §2), turned as well as moved.

The only rule that moves the root; elasticity drags the rest along. Roots are placed from the emitter's own frame, so
nothing drifts however long the animation; the direction that the strand is clamped to turns with it. It acts on the
root before any rule acts on the particles after it, wherever the preset lists it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ...constants import W
from ...scene.motion import emitter_pose
from .rule import Moment, Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

name = "emitter_motion"
order = 0.0


@dataclass(frozen=True, slots=True)
class Parameters:
    """The motion is the emitter's own: its keys."""


def apply(clamp: Any, root: Any, rest_clamp: Any, rest_root: Any, p: Any) -> None:
    """p (12,): a 3 × 3 rotation by rows, then a translation."""
    for k in range(W):
        ax = rest_root[k]
        ay = rest_root[W + k]
        az = rest_root[2 * W + k]
        root[k] = p[0] * ax + p[1] * ay + p[2] * az + p[9]
        root[W + k] = p[3] * ax + p[4] * ay + p[5] * az + p[10]
        root[2 * W + k] = p[6] * ax + p[7] * ay + p[8] * az + p[11]
        bx = rest_clamp[k]
        by = rest_clamp[W + k]
        bz = rest_clamp[2 * W + k]
        clamp[k] = p[0] * bx + p[1] * by + p[2] * bz + p[9]
        clamp[W + k] = p[3] * bx + p[4] * by + p[5] * bz + p[10]
        clamp[2 * W + k] = p[6] * bx + p[7] * by + p[8] * bz + p[11]


def idle(parameters: Parameters, scene: Scene) -> str:
    """Why this rule has nothing to do, or nothing."""
    return "" if len(scene.emitter.keys) > 1 else "the emitter has fewer than two keys: it never moves"


def passes(parameters: Parameters, scene: Scene) -> list[Pass]:
    """One pass."""

    def prepare(moment: Moment) -> Any:
        import numpy as np

        (a, b, c), translation = emitter_pose(moment.scene.emitter, moment.pose_time)
        return np.array([*a, *b, *c, *translation], np.float32)

    return [Pass(apply, prepare, stage="root")]
