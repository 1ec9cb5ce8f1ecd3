"""The foil: the same rods by extended position-based dynamics in small steps.

What most would reach for first, kept to compare with; presets cannot ask for it. One pass over the constraints a step:
its accuracy is bought by more steps alone, and a rod that is stiff for its step comes out too soft. Contact is without
friction and of particles only.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ... import solids
from ...blocks import lanes
from ...constants import W
from ...errors import UsageError
from ...groom.record import Groom
from ...scene.motion import emitter_pose
from ...simulate.rod.material import rigidity
from ...simulate.rod.surroundings import gravity
from ...simulate.rules import collision as collision_rule
from ...simulate.rules import wind as wind_rule
from ...simulate.solver import Solver
from .kernels import foil as kernel

if TYPE_CHECKING:
    from ...scene.model import Scene

APPLIED = ("emitter_motion", "gravity", "wind", "collision", "elasticity", "stiffness")
"""Rules that a scene may list; in place of the last two the foil has its own."""


class Foil(Solver):
    """Strands as rods. ``x`` and ``v`` (blocks, particles, 3 W) float64 are the state; ``mass`` (particles − 1,) is
    that of each particle but the root over a segment's, and may be changed before the first step."""

    def __init__(self, scene: Scene, groom: Groom) -> None:
        strange = [use.name for use in scene.rules if use.name not in APPLIED]
        if strange:
            raise UsageError(f"rule {strange[0]}: the foil does not apply it")
        if scene.emitter.curl_turns > 0 or scene.rod.rest == "sag_free":
            raise UsageError("the foil's rods are straight at rest, without curls and not free of sag")
        super().__init__(scene, groom)
        n = scene.emitter.particles
        lengths = groom.lengths.astype(np.float64) / (n - 1)
        radius = 1 + (scene.rod.tip - 1) * np.arange(n) / (n - 1)
        segments = ((radius[:-1] + radius[1:]) / 2) ** 2
        self.mass = np.append((segments[:-1] + segments[1:]) / 2, segments[-1] / 2)
        self.joint = radius[:-1] ** 4
        self.joint[0] *= 2
        self.stiffness = lanes((rigidity(scene.rod) / lengths**4)[:, None], np.float64)
        self.segment = lanes(lengths[:, None], np.float64)
        self.roots = groom.roots.astype(np.float64)
        self.directions = groom.directions.astype(np.float64)
        self.moving = any(use.name == "emitter_motion" for use in scene.rules)
        self.x = np.ascontiguousarray(self.positions[:, 1:]).astype(np.float64)
        self.v = np.zeros_like(self.x)
        self.before = self.x.copy()
        self.winds = [use.parameters for use in scene.rules if use.name == "wind" and use.parameters.strength > 0]
        self.contacts = [use.parameters for use in scene.rules if use.name == "collision"]
        self.held: tuple[NDArray[np.float64], NDArray[np.float64], float] | None = None
        self.place_roots(1)

    def weight_tip(self, mass: float) -> None:
        """Add to the mass of tips, over that of a segment."""
        self.mass[-1] += mass

    def hold_tip(self, at: tuple[float, float, float], seconds: float = 1.0) -> None:
        """Bring the tip of a single strand to a place (metres) in so many seconds, and keep it there."""
        self.held = (self.x[0, -1].reshape(3, W)[:, 0].copy(), np.array(at), seconds)

    def step(self, time: float, dt: float) -> None:
        """One step of length ``dt`` seconds that ends at ``time``; nothing where ``dt`` is 0."""
        if dt <= 0:
            return
        self.before[:, 0] = self.x[:, 0]
        if self.moving:
            self._place(max(time, 0.0))
        held = np.zeros(0)
        light = np.append(0.0, 1 / self.mass)
        if self.held is not None:
            start, goal, seconds = self.held
            held = start + min(max(time, 0.0) / seconds, 1.0) * (goal - start)
            light[-1] = 0.0
        rod = self.scene.rod
        numbers = np.array([dt, *gravity(self.scene), *self._air(time), rod.drag, rod.damping])
        material = kernel.Material(self.clamp, self.segment, self.stiffness, light, self.joint)
        kernel.step(self.x, self.v, self.before, material, self._gust(time), numbers, held, self._solids(time))
        self.positions[:, 1:] = self.x
        self.positions[:, 0] = self.x[:, 0] - self._lengths() * self.clamp

    def _lengths(self) -> NDArray[np.float64]:
        return np.tile(self.segment, 3)

    def _place(self, time: float) -> None:
        rotation, translation = (np.array(part) for part in emitter_pose(self.scene.emitter, time))
        self.x[:, 0] = lanes(self.roots @ rotation.T + translation, np.float64)
        self.clamp = lanes(self.directions @ rotation.T, np.float64)

    def place_roots(self, frame: int) -> None:
        """By the emitter's pose at a frame."""
        self._place((frame - 1) / self.scene.time.fps if self.moving else 0.0)
        self.positions[:, 1] = self.x[:, 0]
        self.positions[:, 0] = self.x[:, 0] - self._lengths() * self.clamp

    def _air(self, time: float) -> NDArray[np.float64]:
        """Velocity of the air, but for gusts that travel: a wind's strength is a speed here, as for rods."""
        total = np.zeros(3)
        for wind in self.winds:
            phases = wind_rule.phases(self.scene.seed)
            speed = wind.strength
            if not wind_rule.travels(wind):
                speed *= 1 - wind.gust * 0.5 * (1 - wind_rule.gusts(time, wind.period, phases[:3]))
            total += speed * np.array(wind_rule.downwind(wind, time, phases[3:]))
        return total

    def _gust(self, time: float) -> NDArray[np.float64]:
        """(blocks, W) factor of the air's velocity at each root: other than one where gusts travel."""
        travelling = [wind for wind in self.winds if wind_rule.travels(wind)]
        if not travelling:
            return np.ones((len(self.x), W))
        wind = travelling[0]
        way = np.array(wind.direction) / np.linalg.norm(wind.direction)
        along = np.einsum("bck,c->bk", self.x[:, 0].reshape(-1, 3, W), way) / wind.wavelength
        wave = sum(
            share * wind_rule.waves(time / (wind.period * scale) + phase - along / scale)
            for (scale, share), phase in zip(wind_rule.WAVES, wind_rule.phases(self.scene.seed)[:3], strict=True)
        )
        return np.asarray(1 - wind.gust * 0.5 * (1 - wave))

    def _solids(self, time: float) -> solids.Solids:
        touched = {id(one): one for use in self.contacts for one in collision_rule.chosen(use, self.scene)}
        now = max(time, 0.0)
        return solids.pack_all(list(touched.values()), self.scene.emitter, now, np.float64)
