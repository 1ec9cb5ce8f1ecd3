"""Momentum that strands lose to nobody: an error of a frame, measured where forces act."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rod_kit import rod_of
from strand_kit import require_same_after_restart
from strandcli.simulate.contact.forces import Forces
from strandcli.simulate.grid import strand_grid
from strandcli.simulate.grid.strand_grid import Moment
from strandcli.simulate.rod.solver import RodSolver
from tests.simulate.test_grid import rows

BALL = "shape: {kind: sphere, radius: 0.1}, particles: 6, length: 0.2, jitter: 40, strands: 300"
CROWDED = f"emitter: {{{BALL}}}\nrules: [interaction: {{friction: 0.3, cell: 0.03, density: 2000}}]"
FALLING = (
    "time: {fps: 24, substeps: 2}\nemitter: {shape: {kind: sphere, radius: 0.1}, strands: 400, particles: 9, "
    "length: 0.2, jitter: 20, keys: [{time: 0}, {time: 1, rotation: [0, 180, 0]}]}\nchildren: {count: 5}\n"
    "solids: [{kind: sphere, radius: 0.1, follow: emitter}]\n"
    "rules: [emitter_motion, gravity, wind: {strength: 3}, collision, interaction: {cell: 0.03, density: 8000}%s]"
)
BRISTLES = (
    "rod: {radius: 4.0e-4, young: 1.2e+9}\ntime: {fps: 24}\n"
    "emitter: {shape: {kind: disc, radius: 0.01}, strands: 40, particles: 7, length: 0.1, jitter: 12}\n"
    "rules: [gravity: {acceleration: [9.81, 0, 3]}, contact: {thickness: 0.001}]"
)


def lost(solver: RodSolver, frames: int = 24) -> list[float]:
    found = []
    for frame in range(2, frames + 2):
        solver.advance(frame)
        found.append(solver.errors(frame)["momentum_lost"])
    return found  # type: ignore[return-value]


@pytest.mark.parametrize("force", [0.0, 0.02])
def test_it_is_what_velocities_change_by(force: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Free particles, for a second: the same sum as that of their momentum, whether it stays, below 1e-5, or a force
    from nowhere is added. Without it energy falls."""
    real = strand_grid.act

    def act(*given: Any) -> Any:
        found = real(*given)
        given[-2][:, 1] += force  # targets along x
        return found

    monkeypatch.setattr(strand_grid, "act", act)
    solver = rod_of(CROWDED)
    crowd, state, dt = solver.grid, solver.state, 1 / 60
    crowd.samples.mass[crowd.samples.first == 0] = 0
    solver.mass[0] = 0.5  # the emitter would take up what goes to the roots
    state.velocity[...] = np.random.default_rng(1).normal(scale=0.1, size=state.velocity.shape)
    mass = 0.04 * solver.mass[None, :, None].astype(float)
    begin = (mass * rows(state.velocity, 300)).sum((0, 1))
    energies, densest = [], 0.0
    for _ in range(60):
        moment = Moment(dt, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), solver.surroundings.packed())
        crowd.prepare(state, solver.mass, np.zeros_like(solver.drive.roots), moment)
        densest = max(densest, crowd.found / 2000)
        state.velocity[...] += dt * state.acceleration
        energies.append((mass * rows(state.velocity, 300) ** 2).sum())
    change = (mass * rows(state.velocity, 300)).sum((0, 1)) - begin
    total, size = crowd.momentum()
    np.testing.assert_allclose(total, change, atol=1e-6 * size)
    share = solver.errors(2)["momentum_lost"]
    if force:
        assert share > 0.1
    else:
        assert share < 1e-5
        assert densest > 1.5, "pressure had nothing to do"
        assert energies[-1] < 0.5 * energies[0]


@pytest.mark.parametrize("rules", ["", ", contact: {thickness: 0.001}"])
def test_wind_solids_and_roots_are_not_among_it(rules: str) -> None:
    """With all of them, and by the step that reads and writes each pack once or, with contact, by the other one."""
    solver = rod_of(FALLING % rules)
    found = lost(solver, 4 if rules else 24)
    assert max(found) < 1e-6
    assert sum(found) < 1e-5
    assert np.linalg.norm(solver.grid.given) > 0.01 * solver.grid.momentum()[1]


def test_what_a_strand_gets_by_contact_another_loses(monkeypatch: pytest.MonkeyPatch) -> None:
    """Impacts among it, and strands that go by Euler's method beside others; not so where one gets less."""
    solver = rod_of(BRISTLES)
    found = lost(solver, 6)
    assert solver.contact.handed[3] > 0
    assert max(found) < 1e-6
    load = Forces.load

    def weak(self: Forces, held: Any, forces: Any, solver: Any) -> None:
        load(self, held, forces, solver)
        solver.state.acceleration[solver.state.acceleration > 0] *= 0.9

    monkeypatch.setattr(Forces, "load", weak)
    assert max(lost(rod_of(BRISTLES), 6)) > 1e-4


def test_a_frame_has_its_own_steps_alone() -> None:
    solver = rod_of(FALLING % "")
    solver.advance(6)
    whole = solver.grid.momentum()[1]
    again = rod_of(FALLING % "")
    again.advance(5)
    again.begin_frame()
    sizes = 0.0
    for j in range(2):
        again.step((4 + (j + 1) / 2) / 24, 1 / 48)
        sizes += again.grid.momentum()[1]
        again.grid.begin_frame()
    assert whole == pytest.approx(sizes, rel=1e-6)


def test_it_lasts_as_the_state_does_and_is_nothing_at_rest() -> None:
    whole, half = rod_of(FALLING % ""), rod_of(FALLING % "")
    assert whole.errors(1)["momentum_lost"] == 0
    whole.advance(4)
    half.restore({name: one.copy() for name, one in whole.state_arrays().items()})
    assert whole.errors(4) == half.errors(4)
    require_same_after_restart(rod_of(FALLING % ""), rod_of(FALLING % ""))


def test_nothing_of_it_is_there_without_the_rules() -> None:
    solver = rod_of(f"emitter: {{{BALL}}}\nrules: [gravity]")
    solver.advance(2)
    assert "momentum_lost" not in solver.errors(2)
