"""Shapes at rest: curls that turn with their root, and strands of many particles."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rod_kit import take_steps
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.simulate.rod.solver import RodSolver
from strandcli.study.references import elastica
from tests.simulate.test_rod import scene
from tests.simulate.test_rod_motion import first, solver_of


@dataclasses.dataclass(frozen=True)
class Helix(Groom):
    """A groom whose strands wind about x, two turns each, at an angle of 45 degrees."""

    def edge(self, j: int, edges: int) -> NDArray[np.float64]:
        turn = 4 * np.pi * (j + 0.5) / edges
        return np.tile([1.0, np.cos(turn), np.sin(turn)], (self.strands, 1)) / np.sqrt(2)


def helix(**changes: Any) -> RodSolver:
    one = scene(1.0, direction=(1, 0, 0), **{"emitter.particles": 17, **changes})
    groom = emit(one.emitter, one.seed)
    return RodSolver(one, Helix(**{f.name: getattr(groom, f.name) for f in dataclasses.fields(groom)}))


def test_a_curl_turns_with_its_root() -> None:
    keys = [{"time": 0}, {"time": 1, "rotation": [0, 90, 0]}, {"time": 99, "rotation": [0, 90, 0]}]
    solver = helix(rules=["emitter_motion"], **{"emitter.keys": keys, "rod.damping": 0.01})
    x, y, z = first(solver).T
    take_steps(solver, 24, 240)
    np.testing.assert_allclose(first(solver), np.stack([z, y, -x], 1), atol=1e-3)


@pytest.mark.parametrize("particles", [101, 1000])
def test_many_particles_droop_as_the_elastica(particles: int) -> None:
    solver = solver_of(scene(10.0, **{"emitter.particles": particles}))
    take_steps(solver, 2, 60)
    root, *_, tip = first(solver)
    error = (root[1] - tip[1]) / (tip[0] - root[0]) / elastica.hang(10.0).droop - 1
    assert abs(error) < 0.025 * (9 / (particles - 1)) ** 2 + 2e-6  # that of nine segments falls with their square
    assert solver.residual() <= 1e-3  # type: ignore[operator]


@pytest.mark.parametrize("rate", [2, 24, 240])
@pytest.mark.parametrize(("angle", "turns"), [(20.0, 1.5), (45.0, 2.0), (60.0, 3.0), (35.0, 5.0)])
def test_curls_come_to_rest(angle: float, turns: float, rate: int) -> None:
    """Nothing but its own stiffness acts on a coil that was struck: whatever moves for long has found energy."""
    curl = {"emitter.curl_angle": angle, "emitter.curl_turns": turns}
    solver = solver_of(scene(10.0, **{"emitter.particles": 41, "rules": [], **curl}))
    solver.state.velocity.reshape(1, 40, 3, -1)[:, :, 0] += 0.1
    steps = 8 * max(rate, 24)
    for i in range(steps):
        before = first(solver)
        solver.step((i + 1) / rate, 1 / rate)
        if i > 0.9 * steps:
            assert np.abs(first(solver) - before).max() * rate < 0.02


@pytest.mark.parametrize(("angle", "turns"), [(20.0, 1.5), (35.0, 3.0)])
def test_curls_droop_the_same_with_more_particles(angle: float, turns: float) -> None:
    """A curl is not made stiff by being carried along: no stiffer with 61 particles than with 25."""
    tips = []
    for particles in (25, 61):
        curl = {"emitter.curl_angle": angle, "emitter.curl_turns": turns, "rod.damping": 0.05}
        solver = solver_of(scene(10.0, **{"emitter.particles": particles, **curl}))
        take_steps(solver, 10, 300)
        tips.append(first(solver)[-1] - first(solver)[0])
    assert tips[0][1] < -0.5
    assert np.abs(tips[1] - tips[0]).max() < 0.02
