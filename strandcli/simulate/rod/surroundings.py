"""External influences on rods in a step: the emitter's pose, gravity, air, and solids with their motion.

Constants, such as solids that do not move, are computed once.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import sub
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ... import solids
from ...constants import W
from ...errors import UsageError
from ...scene.motion import Pose, emitter_pose, multiply, rotate, solid_pose
from ...scene.rule_type import touched
from ...solids import Solids, custom
from ..rules import wind
from .kernels.arrays import MOTION

if TYPE_CHECKING:
    from ...scene.model import Scene


def gravity(scene: Scene) -> NDArray[np.float64]:
    """Return (3,) the sum of all gravity rules, m/s²."""
    pulls = [use.parameters.acceleration for use in scene.rules if use.name == "gravity"]
    return np.asarray(np.sum([np.zeros(3), *pulls], axis=0))


class Surroundings:
    """External influences on the rods of a scene, in a floating-point type. Raises `UsageError` for a combination of
    winds that rods do not support."""

    def __init__(self, scene: Scene, dtype: Any) -> None:
        self.scene, self.dtype = scene, dtype
        self.gravity = gravity(scene)
        self.carried = any(use.name == "emitter_motion" for use in scene.rules)
        """Whether roots follow the emitter."""
        self._loop = scene.time.period
        self.winds = [use.parameters for use in scene.rules if use.name == "wind" and use.parameters.strength > 0]
        self._travelling = [one for one in self.winds if wind.travels(one)]
        if self._travelling and len(self.winds) > 1:  # each strand has one factor for the total velocity of the air
            raise UsageError(
                f"{scene.source or 'scene'}: rule wind: of {len(self.winds)} winds, {len(self._travelling)} with gusts "
                "that travel: the solver rod supports travelling gusts only without another wind; set wavelength: 0, "
                "remove the other winds, or use solver: thesis"
            )
        phases = wind.phases(scene.seed).tolist()
        self._phases, self._swings = phases[:3], phases[3:]
        met = touched(scene)
        self._met, self.any_solids = met, bool(met)
        self.segments = bool(met) and any(use.name == "collision" and use.parameters.segments for use in scene.rules)
        """Whether whole segments stay out of solids, and not only particles."""
        kinds = {kind: [one for one in met if one.kind == kind] for kind in solids.COLUMNS}
        self.custom = solids.custom_of(met)
        """Solids without kernels of their own; their kind is "" here."""
        if self.custom:
            kinds[""] = self.custom
        self.data = custom.data_of(self.custom, scene.time.pose_time(0.0))
        """The arrays of their shapes at the end of the last step."""
        packed = {kind: self._at_rest(kind, mine) for kind, mine in kinds.items()}
        self._packed = tuple(packed.values())
        moving = {kind: [one for one in mine if self._moves(one)] for kind, mine in kinds.items()}
        self._moving = [
            pair for kind, mine in moving.items() if mine for pair in zip(packed[kind][-len(mine) :], mine, strict=True)
        ]

    def air(self, time: float) -> tuple[float, float, float]:
        """Return the velocity of the air, m/s, without gusts that differ from strand to strand."""
        x = y = z = 0.0
        for one in self.winds:
            speed = one.strength
            if one not in self._travelling:
                speed *= 1 - one.gust * 0.5 * (1 - wind.gusts(time, one.period, self._phases, self._loop))
            down = wind.downwind(one, time, self._swings, self._loop)
            x, y, z = x + speed * down[0], y + speed * down[1], z + speed * down[2]
        return x, y, z

    def gust(self, time: float, positions: NDArray[Any]) -> NDArray[Any] | None:
        """Return (blocks, W) the factor of the air's velocity at each strand, or None if it is 1 for all; positions
        (blocks, rows, 3 W), whose row 1 is the root."""
        if not self._travelling:
            return None
        one = self._travelling[0]
        roots = positions[:, 1].reshape(-1, 3, W).astype(np.float64)
        down = np.array(one.direction) / np.linalg.norm(one.direction)
        along = np.einsum("bck,c->bk", roots, down) / one.wavelength
        wave = wind.gusts(time, one.period, self._phases, self._loop, along)
        return np.asarray(1 - one.gust * 0.5 * (1 - wave)).astype(self.dtype)

    def pose(self, time: float) -> Pose:
        """Return the emitter's pose; at rest where no rule carries the roots along."""
        emitter = self.scene.emitter
        return emitter_pose(emitter, self.scene.time.pose_time(time) if self.carried and emitter.keys else 0.0)

    def solids(self, time: float, dt: float) -> tuple[Any, ...]:
        """Return packed solids with their motion in a step of ``dt`` seconds that ends at ``time``: spheres, capsules,
        planes, boxes, and `custom` if there are any. The arrays are the same at each call; those of `data` are new when
        a shape changes."""
        now, past = self.scene.time.pose_time(time), self.scene.time.pose_time(time - dt)
        emitter = self.scene.emitter
        outer, inner = (emitter_pose(emitter, at) if self._moving else None for at in (now, past))
        for row, one in self._moving:
            moved = solid_pose(one, emitter, now, outer)
            motion = _between(solid_pose(one, emitter, past, inner), moved)
            row[:] = *self._numbers(one, moved, len(row) - MOTION), *flat(motion)
        if self.data:
            found = custom.data_of(self.custom, now, past)
            if any(a is not b for a, b in zip(found, self.data, strict=True)):
                self.data = found
        return self._packed

    def packed(self) -> Solids | None:
        """Return the solids at the end of the last step for kernels that draw or look, as `solids.pack_all` packs them,
        each kind in an order of its own and with columns for the motion; None where there are none."""
        if not self.any_solids:
            return None
        return solids.joined_with(self._met, [one.astype(np.float32, copy=False) for one in self._packed], self.data)

    def _numbers(self, solid: Any, pose: Pose, columns: int) -> list[float]:
        """Return a solid's packed row."""
        if solid.kind in solids.COLUMNS:
            return solids.numbers(solid, pose)
        found = custom.numbers(solid, pose, self.custom)
        return found + [0.0] * (columns - len(found))

    def _moves(self, solid: Any) -> bool:
        return bool(solid.keys) or (solid.follow == "emitter" and bool(self.scene.emitter.keys))

    def _at_rest(self, kind: str, mine: list[Any]) -> NDArray[Any]:
        """Return (m, columns + `MOTION`) all solids of a kind at time 0 without motion, moving ones last."""
        mine = sorted(mine, key=self._moves)
        columns = solids.COLUMNS[kind] if kind else custom.columns_of(mine)
        rows = np.zeros((len(mine), columns + MOTION), self.dtype)
        for row, one in zip(rows, mine, strict=True):
            row[:columns] = self._numbers(one, solid_pose(one, self.scene.emitter, 0.0), columns)
        rows[:, columns : columns + 9] = np.eye(3).ravel()
        return rows


def flat(pose: Pose) -> tuple[float, ...]:
    """Return (12,) a pose's rotation by rows and its translation."""
    a, b, c = pose.rotation
    return (*a, *b, *c, *pose.translation)


def change_of(last: Pose, pose: Pose) -> tuple[float, ...]:
    """Return (12) the change from one pose to another: of its rotation by rows, and of its translation."""
    return tuple(map(sub, flat(pose), flat(last)))


def pose_of(numbers: Sequence[float]) -> Pose:
    """Return the pose with these 12 numbers, as `flat` has them."""
    a, b, c, d, e, f, g, h, i, x, y, z = numbers
    return Pose(((a, b, c), (d, e, f), (g, h, i)), (x, y, z))


def _between(last: Pose, pose: Pose) -> Pose:
    """Return the rigid motion from one pose to another."""
    (a, b, c), (d, e, f), (g, h, i) = last.rotation
    turn = multiply(pose.rotation, ((a, d, g), (b, e, h), (c, f, i)))
    x, y, z = rotate(turn, last.translation)
    p = pose.translation
    return Pose(turn, (p[0] - x, p[1] - y, p[2] - z))
