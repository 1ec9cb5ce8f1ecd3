"""Base class of solvers: strands in blocks, the clock, and the errors of a frame."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import solids
from ..constants import W
from ..groom.blocks import lanes, on_large_pages, pack, unpack
from ..groom.deforming import deforming
from ..groom.record import Groom, check
from ..scene.motion import emitter_pose
from ..scene.rule_type import touched
from .contact.kernels import measure

if TYPE_CHECKING:
    from ..scene.model import Scene


ANNOUNCED = 8
"""Steps that are announced at once."""


class Solver(ABC):
    """Strands of one groom, moved from frame to frame.

    ``positions`` (blocks, particles + 1, 3 W) float32 metres are drawn, in the layout of `strandcli.groom.blocks`;
    ``lengths`` (blocks, W) are the rest lengths of segments. Both are in the groom's order of strands; arguments and
    results of methods are in the order of emission. Raises `UsageError` for a groom that `check` refuses.
    """

    independent = False
    """Whether a frame does not depend on those before it."""

    def __init__(self, scene: Scene, groom: Groom) -> None:
        check(groom)
        self.scene = scene
        self.groom = groom
        self.strands = groom.strands
        n = scene.emitter.particles
        rest_length = groom.lengths.astype(np.float64) / (n - 1)
        rotation, translation = (np.array(part) for part in emitter_pose(scene.emitter, 0.0))
        blocks = -(-groom.strands // W)
        self.positions = on_large_pages((blocks, n + 1, 3 * W))
        self.rest = np.empty((blocks, 2, 3 * W), np.float32)
        local = groom.roots - rest_length[:, None] * groom.directions
        for row in range(n + 1):
            self.positions[:, row] = lanes(local @ rotation.T + translation)
            if row < 2:
                self.rest[:, row] = lanes(local)
            direction = groom.directions if row == 0 else groom.edge(row - 1, n - 1)
            local = local + rest_length[:, None] * direction
        self.lengths = lanes(rest_length[:, None])
        self.deforming = deforming(scene, groom)
        """The roots, where they move in the emitter's frame."""
        self._frame = 0
        self._announced = 0
        """Frame up to whose begin steps are announced."""

    @abstractmethod
    def step(self, time: float, dt: float) -> None:
        """Simulate a step of ``dt`` seconds that ends at ``time``; do nothing if ``dt`` is 0."""

    def announce(self, ends: Sequence[float], dt: float) -> None:  # noqa: B027  which most need not hear
        """Prepare for steps of ``dt`` seconds with these ends, likely to come next, unless the solver goes on from
        another state: what follows from time alone can be computed for all of them together."""

    @abstractmethod
    def place_roots(self, frame: int) -> None:
        """Set the two rows that rules do not simulate, the root and the one before it, at a frame."""

    def strand_residuals(self) -> NDArray[np.floating] | None:
        """Return (strands,) the greatest error of each after the solver's iterations in the last step; None for a
        solver without iterations."""
        return None

    def residual(self) -> float | None:
        """Return the greatest of `strand_residuals`; NaN if one is NaN, None if there are none."""
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
        substeps = time.substeps
        while self._frame < frame:
            if self._frame >= self._announced:
                self._announced = self._frame + max(ANNOUNCED // substeps, 1)
                frames = range(self._frame, self._announced) if substeps < ANNOUNCED else ()
                self.announce([(f - 1 + (j + 1) / substeps) / time.fps for f in frames for j in range(substeps)], dt)
            for j in range(substeps):
                self.step((self._frame - 1 + (j + 1) / substeps) / time.fps, dt)
            self._frame += 1

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return all that later steps read and earlier ones have changed: by name, arrays that always have the same
        types and shapes for a scene; none where a frame does not depend on those before it."""
        return {"clock": np.array([self._frame], np.float64), "positions": self.positions}

    def check(self, state: Mapping[str, NDArray[Any]], frame: int) -> None:
        """Raise `ValueError` for a state that is none of a frame; the hash of its file does not tell who wrote it."""
        if state["clock"][0] != frame:
            raise ValueError("it is of another frame")

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from a state that `state_arrays` of a solver of the same scene has returned."""
        self._frame, self._announced = int(state["clock"][0]), 0
        self.positions[...] = state["positions"]

    def take(self, frame: int, particles: NDArray[np.floating]) -> None:
        """Set the particles of a frame that was simulated before, (strands or more, particles, 3) metres."""
        self.place_roots(frame)
        self.positions[:, 1:] = pack(self.groom.placed(particles[: self.strands]))

    def particles(self) -> NDArray[np.float32]:
        """Return the particles (strands, particles, 3) float32, metres."""
        return self.groom.emitted(unpack(self.positions[:, 1:], self.strands))

    def rest_lengths(self) -> NDArray[np.float32]:
        """Return (strands,) the rest length of a segment, metres."""
        return self.groom.emitted(self.lengths.reshape(-1)[: self.strands])

    def errors(self, frame: int) -> dict[str, float | None]:
        """Return the errors at a frame.

        ``stretch_max``: greatest error of a segment's length, as a share of its rest length; ``penetration_max``:
        greatest depth of a particle in a solid, and ``segment_penetration_max`` of any point of a segment, metres, None
        without solids to collide with; ``residual_max``: `residual`; ``nonfinite``: number of coordinates that are not
        finite. Roots are left out, and of a first segment only the depth in excess of its root's counts.
        """
        particle, segment = self._depths(max((frame - 1) / self.scene.time.fps, 0.0))
        return {
            "stretch_max": self.stretch(),
            "penetration_max": particle,
            "segment_penetration_max": segment,
            "residual_max": self.residual(),
            "nonfinite": int(np.count_nonzero(~np.isfinite(self.positions[:, 1:]))),
        }

    def stretch(self) -> float:
        """Return the greatest error of a segment's length, as a share of its rest length."""
        found = np.zeros(len(self.positions), np.float32)
        measure.stretches(self.positions, self.lengths, found)
        return float(found.max())

    def _depths(self, time: float) -> tuple[float, float] | tuple[None, None]:
        met = touched(self.scene)
        if not met:
            return None, None
        out = np.zeros((len(self.positions), measure.COLUMNS), np.float32)
        measure.depths(self.positions, solids.pack_all(met, self.scene.emitter, time), out)
        return float(out[:, measure.PARTICLES].max()), float(out[:, measure.SEGMENTS].max())
