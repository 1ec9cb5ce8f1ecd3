"""Strands with free roots: a few of the same length, where they are and how they move, roots among their particles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from strand_kit import scene_of
from strandcli.constants import W
from strandcli.groom.record import Groom
from strandcli.simulate.kernels.rod_scratch import PACK
from strandcli.simulate.rod import RodSolver

Floats = NDArray[np.float64]

G = 9.81
SEGMENTS = 10
LENGTH = 0.3
STEP = 1 / 60


def groom_about(middles: Any, ways: Any) -> Groom:
    """Straight strands about their middles."""
    way = np.array(ways, np.float64)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    roots, count = np.array(middles) - LENGTH / 2 * way, len(way)
    lengths, tones = np.full(count, LENGTH, np.float32), np.zeros(count, np.float32)
    return Groom(roots.astype(np.float32), way.astype(np.float32), lengths, tones)


class Loose:
    """Strands with free roots, of a groom that is in the order of its packs."""

    def __init__(self, groom: Groom, rules: str, rod: str = "drag: 0", solids: str = "") -> None:
        scene = scene_of(
            f"solver: rod\nrod: {{root: free, rest: straight, radius: 0.001, young: 1.0e+8, damping: 0, {rod}}}\n"
            f"time: {{fps: 60, preroll: 0}}\nsolids: [{solids}]\nrules: [{rules}]\n"
            f"emitter: {{strands: {groom.strands}, particles: {SEGMENTS + 1}, length: {LENGTH}}}\n"
        )
        self.solver, self.strands, self.steps = RodSolver(scene, groom), groom.strands, 0
        each = np.append(0.5, self.solver.mass.astype(float))
        self.mass: Floats = (LENGTH / SEGMENTS * each)[None, :, None]
        """(1, N + 1, 1) of particles, metres of strand."""

    def places(self) -> Floats:
        """(S, N + 1, 3) metres."""
        return self._rows(self.solver.state.positions[:, 1:], W)

    def velocities(self) -> Floats:
        """(S, N + 1, 3) m/s."""
        both = self.solver.state.root_velocity, self.solver.state.velocity
        return self._rows(np.concatenate(both, 1), PACK)

    def _rows(self, rows: NDArray[Any], width: int) -> Floats:
        wide = rows.astype(np.float64).reshape(*rows.shape[:2], 3, width).transpose(0, 3, 1, 2)
        return np.asarray(wide.reshape(-1, rows.shape[1], 3)[: self.strands])

    def throw(self, velocities: Floats) -> None:
        """Give particles (S, N + 1, 3) velocities, m/s."""
        packs = len(self.solver.state.edges)
        full = np.zeros((packs * PACK, SEGMENTS + 1, 3))
        full[: self.strands] = velocities
        rows = full.reshape(packs, PACK, SEGMENTS + 1, 3).transpose(0, 2, 3, 1).reshape(packs, SEGMENTS + 1, -1)
        self.solver.state.root_velocity[...], self.solver.state.velocity[...] = rows[:, :1], rows[:, 1:]

    def momentum(self) -> tuple[Floats, Floats]:
        """Momentum and angular momentum of all (3), metres times m/s and m²/s."""
        p = self.mass * self.velocities()
        return p.sum((0, 1)), np.cross(self.places(), p).sum((0, 1))

    def centre(self) -> Floats:
        """(S, 3) centres of mass, metres."""
        return np.asarray((self.mass * self.places()).sum(1) / self.mass.sum())

    def run(self, seconds: float) -> None:
        """Go on for so long."""
        for _ in range(round(seconds / STEP)):
            self.steps += 1
            self.solver.begin_frame()
            self.solver.step(self.steps * STEP, STEP)
