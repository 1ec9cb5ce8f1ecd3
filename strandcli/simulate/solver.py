"""What solvers have in common: strands in blocks, the clock, and the errors of a frame."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import solids
from ..blocks import aligned, lanes, pack, unpack
from ..constants import W
from ..groom.check import check
from ..groom.record import Groom
from ..scene.motion import emitter_pose
from ..scene.touched import touched
from .kernels import measure

if TYPE_CHECKING:
    from ..scene.model import Scene


class Solver(ABC):
    """Strands of one groom, moved from frame to frame.

    ``positions`` (blocks, particles + 1, 3 W) float32 metres is what is drawn, in the layout of `strandcli.blocks`;
    ``lengths`` (blocks, W) are the rest lengths of segments, both of strands as they stand in the groom; all that
    methods tell or take of strands is in the order of emission. Raises `UsageError` for a groom that `check` refuses.
    """

    def __init__(self, scene: Scene, groom: Groom) -> None:
        check(groom)
        self.scene = scene
        self.groom = groom
        self.strands = groom.strands
        n = scene.emitter.particles
        rest_length = groom.lengths.astype(np.float64) / (n - 1)
        rotation, translation = (np.array(part) for part in emitter_pose(scene.emitter, 0.0))
        blocks = -(-groom.strands // W)
        self.positions = aligned((blocks, n + 1, 3 * W))
        self.rest = np.empty((blocks, 2, 3 * W), np.float32)
        local = groom.roots - rest_length[:, None] * groom.directions
        for row in range(n + 1):
            self.positions[:, row] = lanes(local @ rotation.T + translation)
            if row < 2:
                self.rest[:, row] = lanes(local)
            way = groom.directions if row == 0 else groom.edge(row - 1, n - 1)
            local = local + rest_length[:, None] * way
        self.lengths = lanes(rest_length[:, None])
        self._frame = 0

    @abstractmethod
    def step(self, time: float, dt: float) -> None:
        """One step of length ``dt`` seconds that ends at ``time``; nothing where ``dt`` is 0."""

    @abstractmethod
    def place_roots(self, frame: int) -> None:
        """Put the two rows that rules do not simulate, the root and the one before it, where they are at a frame."""

    def strand_residuals(self) -> NDArray[np.floating] | None:
        """(strands,) the greatest error that the solver itself left in each in the last step; None where it has no such
        notion."""
        return None

    def residual(self) -> float | None:
        """The greatest of `strand_residuals`; NaN where one is, None where there are none."""
        found = self.strand_residuals()
        return None if found is None else float(found.max())

    def advance(self, frame: int) -> None:
        """Simulate up to a frame; 1 is the start, after the pre-roll."""
        time = self.scene.time
        dt = 1.0 / (time.fps * time.substeps)
        if self._frame == 0:
            before = round(time.preroll * time.fps * time.substeps)
            for j in range(before):
                self.step((j + 1 - before) * dt, dt)
            self._frame = 1
        while self._frame < frame:
            for j in range(time.substeps):
                self.step((self._frame - 1 + (j + 1) / time.substeps) / time.fps, dt)
            self._frame += 1

    def take(self, frame: int, particles: NDArray[np.floating]) -> None:
        """Set the particles of a frame, (strands or more, particles, 3) metres, as they were simulated before."""
        self.place_roots(frame)
        self.positions[:, 1:] = pack(self.groom.placed(particles[: self.strands]))

    def particles(self) -> NDArray[np.float32]:
        """(strands, particles, 3) float32, metres."""
        return self.groom.emitted(unpack(self.positions[:, 1:], self.strands))

    def rest_lengths(self) -> NDArray[np.float32]:
        """(strands,) of a segment, metres."""
        return self.groom.emitted(self.lengths.reshape(-1)[: self.strands])

    def errors(self, frame: int) -> dict[str, float | None]:
        """Errors at a frame: ``stretch_max``, the greatest error of a segment's length, a share of its rest length;
        ``penetration_max``, the greatest depth of a particle in a solid, and ``segment_penetration_max``, that of any
        place of a segment, both in metres and None where nothing is collided with; ``residual_max``; ``nonfinite``, the
        number of coordinates that are not finite. Roots are left out, and of a first segment only what is deeper than
        its root counts."""
        out = np.zeros((len(self.positions), 2), np.float32)
        measure.strands(self.positions, self.lengths, out)
        particle, segment = self._depths(max((frame - 1) / self.scene.time.fps, 0.0))
        return {
            "stretch_max": float(out[:, 0].max()),
            "penetration_max": particle,
            "segment_penetration_max": segment,
            "residual_max": self.residual(),
            "nonfinite": int(out[:, 1].sum()),
        }

    def _depths(self, time: float) -> tuple[float, float] | tuple[None, None]:
        met = touched(self.scene)
        if not met:
            return None, None
        out = np.zeros((len(self.positions), 2), np.float32)
        measure.depths(self.positions, solids.pack_all(met, self.scene.emitter, time), out)
        return float(out[:, 0].max()), float(out[:, 1].max())
