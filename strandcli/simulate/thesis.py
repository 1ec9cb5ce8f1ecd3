"""The source's solver: its rules, in the preset's order, once a step, and nothing else (thesis §2).

It has no velocity, so nothing has inertia; a rule's strength depends on the step; collision is per point; the shape
depends on the number of particles. These are the source's flaws and are kept, so that they can be seen and measured.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import runtime, solids
from ..blocks import lanes, pack, unpack
from ..constants import W
from ..groom.emit import Groom
from ..scene.motion import emitter_pose
from .compose import step_for
from .kernels import measure
from .rules import Moment, Pass, idle, registry
from .rules import collision as collision_rule


class ThesisSolver:
    """Strands of one groom, moved from frame to frame.

    ``positions`` (blocks, particles + 1, 3 W) float32 is the state, in the layout of `strandcli.blocks`.
    """

    def __init__(self, scene: Any, groom: Groom) -> None:
        self.scene = scene
        self.strands = groom.strands
        n = scene.emitter.particles
        rest_length = groom.lengths.astype(np.float64) / (n - 1)
        rotation, translation = (np.array(part) for part in emitter_pose(scene.emitter, 0.0))
        blocks = -(-groom.strands // W)
        self.positions = np.empty((blocks, n + 1, 3 * W), np.float32)
        self.rest = np.empty((blocks, 2, 3 * W), np.float32)
        for row in range(n + 1):
            local = groom.roots + (row - 1) * rest_length[:, None] * groom.directions
            self.positions[:, row] = lanes(local @ rotation.T + translation)
            if row < 2:
                self.rest[:, row] = lanes(local)
        self.lengths = lanes(rest_length[:, None])
        self.passes: list[Pass] = [
            one
            for use in scene.rules
            if not idle(use, scene)
            for one in registry()[use.name].passes(use.parameters, scene)
        ]
        self._step = step_for(tuple(self.passes), runtime.cache_folder()) if self.passes else None
        self._frame = 0

    def advance(self, frame: int) -> None:
        """Move on to a frame (1 is the start, after the pre-roll)."""
        time = self.scene.time
        dt = 1.0 / (time.fps * time.substeps)
        if self._frame == 0:
            before = round(time.preroll / dt)
            for j in range(before):
                self.step((j + 1 - before) * dt, dt)
            self._frame = 1
        while self._frame < frame:
            for j in range(time.substeps):
                self.step((self._frame - 1 + (j + 1) / time.substeps) / time.fps, dt)
            self._frame += 1

    def step(self, time: float, dt: float) -> None:
        """One step of length ``dt`` seconds that ends at ``time``."""
        if self._step is not None and dt > 0:
            moment = Moment(time, dt, self.scene)
            self._step(self.positions, self.lengths, self.rest, *[one.prepare(moment) for one in self.passes])

    def take(self, frame: int, particles: NDArray[np.floating]) -> None:
        """Set the particles of a frame, (strands or more, particles, 3) metres, as they were simulated before.

        The row before the root is not among them: rules that move roots set it, as `advance` would have.
        """
        roots = [one for one in self.passes if one.stage == "root"]
        if roots and (frame > 1 or self.scene.time.preroll > 0):
            time = self.scene.time
            moment = Moment((frame - 1) / time.fps, 1.0 / (time.fps * time.substeps), self.scene)
            step = step_for(tuple(roots), runtime.cache_folder())
            step(self.positions, self.lengths, self.rest, *[one.prepare(moment) for one in roots])
        self.positions[:, 1:] = pack(particles[: self.strands])

    def particles(self) -> NDArray[np.float32]:
        """(strands, particles, 3) float32, metres."""
        return unpack(self.positions[:, 1:], self.strands)

    def errors(self, frame: int) -> dict[str, float | None]:
        """Greatest stretch (a share of the rest length), greatest depth inside a solid (metres; None where nothing is
        collided with) and the number of coordinates that are not finite, at a frame."""
        out = np.zeros((len(self.positions), 2), np.float32)
        measure.strands(self.positions, self.lengths, out)
        return {
            "stretch_max": float(out[:, 0].max()),
            "penetration_max": self._depth(max((frame - 1) / self.scene.time.fps, 0.0)),
            "residual_max": None,
            "nonfinite": int(out[:, 1].sum()),
        }

    def _depth(self, time: float) -> float | None:
        touched = {
            id(solid): solid
            for use in self.scene.rules
            if use.name == "collision"
            for solid in collision_rule.chosen(use.parameters, self.scene)
        }
        if not touched:
            return None
        kinds = [solids.pack(kind, list(touched.values()), self.scene.emitter, time) for kind in solids.COLUMNS]
        out = np.zeros(len(self.positions), np.float32)
        measure.depth(self.positions, *kinds, out)
        return float(out.max())
