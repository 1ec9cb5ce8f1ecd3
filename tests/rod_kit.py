"""What tests of rods share: solvers from short texts, and steps of equal length."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from strand_kit import scene_of
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.simulate.rod.solver import RodSolver


def rod_of(text: str, groom: Groom | None = None, double: bool = False) -> RodSolver:
    """The solver of a text, which need not name it."""
    scene = scene_of("solver: rod\n" + text)
    return RodSolver(scene, groom or emit(scene.emitter, scene.seed), double)


def each_step(solver: RodSolver, rate: float, count: int) -> Iterator[int]:
    """Numbers of so many steps, each after it has been taken; ``rate``: steps a second."""
    for i in range(count):
        solver.step((i + 1) / rate, 1 / rate)
        yield i


def take_steps(solver: RodSolver, rate: float, count: int) -> None:
    """Take so many steps from the beginning on."""
    for _ in each_step(solver, rate, count):
        pass


def motion_at_rest(solver: RodSolver, rate: int, seconds: int) -> NDArray[np.float64]:
    """(frames, strands, particles) how far they move about their roots in each frame of the last second, metres."""
    seen = []
    for i in each_step(solver, rate, seconds * rate):
        if i >= (seconds - 1) * rate - 1:
            particles = solver.particles().astype(np.float64)
            seen.append(particles - particles[:, :1])
    return np.asarray(np.linalg.norm(np.diff(seen, axis=0), axis=-1))


def rms(moved: NDArray[np.float64]) -> float:
    return float(np.sqrt((moved**2).mean()))
