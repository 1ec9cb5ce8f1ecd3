"""How the surroundings of rods move in a step: the emitter's pose, the air, solids.

They follow from time alone. Between frames the picture takes the processor's caches, and the first step after it finds
neither this code nor what it reads: a step's numbers then take three times as long as those of the steps that follow at
once. So `announce` has those of several steps computed together.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import sub
from typing import TYPE_CHECKING, NamedTuple

from ...groom.record import Groom
from ...scene.motion import Pose, emitter_pose
from .roots import Jumps
from .surroundings import Placed, Poses, Surroundings, flat

if TYPE_CHECKING:
    from ...scene.model import Scene


class Moved(NamedTuple):
    """What moves in a step."""

    last: Pose
    """Of the emitter at the end of the step before."""
    pose: Pose
    """At the end of this step."""
    jumps: bool
    """Whether some root has been put elsewhere; the pose does not change then in this step."""
    change: tuple[float, ...]
    """(12) of the pose in this step: of its rotation by rows, and of its translation."""
    air: tuple[float, float, float]
    """Velocity, m/s."""
    solids: Placed


class Motion:
    """What moves in the steps of a scene."""

    def __init__(self, scene: Scene, groom: Groom, surroundings: Surroundings) -> None:
        self._scene, self._surroundings = scene, surroundings
        self.carried = any(use.name == "emitter_motion" for use in scene.rules)
        """Whether roots follow the emitter."""
        self._still = emitter_pose(scene.emitter, 0.0)
        self._jumps = Jumps(groom)
        self._known: dict[tuple[float, float], Moved] = {}

    def pose(self, time: float) -> Pose:
        """The emitter's pose; at rest where no rule carries the roots along."""
        if self.carried and self._scene.emitter.keys:
            return emitter_pose(self._scene.emitter, self._scene.time.pose_time(time))
        return self._still

    def announce(self, ends: Sequence[float], dt: float, last: Pose) -> None:
        """Compute what moves in steps of ``dt`` seconds with these ends, which are likely to come next; ``last``: the
        emitter's pose before them."""
        self._known.clear()
        poses = self._surroundings.poses
        for time in ends:
            self._known[time, dt] = moved = self._moved(time, dt, last, poses)
            last, poses = moved.pose, moved.solids.after

    def step(self, time: float, dt: float, last: Pose) -> Moved:
        """Return what moves in a step of ``dt`` seconds that ends at ``time``."""
        known = self._known.get((time, dt))
        if known is None or known.last is not last:
            return self._moved(time, dt, last, self._surroundings.poses)
        return known

    def _moved(self, time: float, dt: float, last: Pose, before: Poses) -> Moved:
        around, pose = self._surroundings, self.pose(time)
        jumps = self._jumps.between(last, pose)
        air = around.air(time)
        solids = around.placed(time, dt, self.outer(pose), before)
        change = change_of(pose if jumps else last, pose)
        return Moved(last, pose, jumps, change, air, solids)

    def outer(self, pose: Pose) -> Pose | None:
        """The emitter's pose as solids take it that follow it."""
        return pose if self.carried else None


def change_of(last: Pose, pose: Pose) -> tuple[float, ...]:
    """Return (12) the change from one pose to another: of its rotation by rows, and of its translation."""
    return tuple(map(sub, flat(pose), flat(last)))
