"""Shapes at rest: curls and their energy, strands of many particles, grooms that hang still as they are emitted."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rod_kit import each_step, rod_of, take_steps
from strand_kit import require_same_after_restart
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.simulate import advice
from strandcli.simulate.rod.rest_shape import SAFETY, TILT, TURNS
from strandcli.simulate.rod.solver import RodSolver
from strandcli.study.references import elastica
from tests.simulate.test_rod import PULL, scene, solver_of
from tests.simulate.test_rod_motion import first


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


LEVEL, UP, HANGING, RISING, FALLING = (1, 0, 0), (0, 1, 0), (0, -1, 0), (1, 0.6, 0), (1, -1, 0)
WAYS = [LEVEL, UP, HANGING, RISING, FALLING]
STIFF = [(10.0, 10), (100.0, 10), (1e4, 1), (1e4, 2), (1e4, 10), (1e4, 20), (1e4, 32)]
BUCKLING = 7.83735  # Γ of an upright column that buckles under its own weight


def held(gamma: float, segments: int, way: tuple[float, float, float], **changes: Any) -> RodSolver:
    changes = {"rod.rest": "sag_free", "emitter.particles": segments + 1, **changes}
    return solver_of(scene(gamma, direction=way, **changes))


def stiffer(solver: RodSolver, gamma: float) -> float:
    """How many times as stiff as the material the first strand is."""
    return float(solver.material.stiffness[0, 0] * solver.material.lengths[0, 0] ** 4 / (PULL / gamma))


@pytest.mark.parametrize(
    ("gamma", "segments", "way"),
    [
        *((gamma, segments, way) for way in WAYS for gamma, segments in STIFF), (1e4, 999, LEVEL), (1e4, 999, FALLING)
    ],
)  # fmt: skip
def test_nothing_moves(gamma: float, segments: int, way: tuple[float, float, float]) -> None:
    for dt in (1 / 240, 1 / 24, 0.5):
        solver = held(gamma, segments, way)
        start = first(solver)
        for i in range(8 if segments > 32 else 96):
            solver.step((i + 1) * dt, dt)
            assert np.abs(first(solver) - start).max() <= 1e-6


@pytest.mark.parametrize("way", [LEVEL, UP, RISING, FALLING])
@pytest.mark.parametrize(("gamma", "angle", "rate"), [(10.0, 30, 24), (1e4, 30, 24), (1e4, 120, 24), (1e4, 30, 240)])
def test_it_finds_back_when_its_root_has_turned(
    gamma: float, angle: float, rate: int, way: tuple[float, float, float]
) -> None:
    keys = [{"time": 0}, {"time": 0.25, "rotation": [0, 0, angle]}, {"time": 0.5}, {"time": 99}]
    gravity = {"gravity": {"acceleration": [0, -PULL, 0]}}
    solver = held(gamma, 10, way, **{"emitter.keys": keys, "rules": ["emitter_motion", gravity]})
    start = first(solver)
    away = 0.0
    for _ in each_step(solver, rate, 16 * rate):
        away = max(away, float(np.abs(first(solver) - start).max()))
    assert away > 0.05
    assert np.abs(first(solver) - start).max() <= 1e-6


def test_strands_that_can_hold_their_shape_stay_as_they_are() -> None:
    for gamma, way in [(1e4, HANGING), (100.0, (0.05, -1, 0)), (10.0, LEVEL), (5.0, UP)]:
        solver = held(gamma, 10, way)
        assert stiffer(solver, gamma) == pytest.approx(1, rel=1e-5)
        assert advice.softness(solver.scene, solver.groom) == []


def test_strands_that_cannot_are_made_stiffer_and_say_so() -> None:
    """One of two strands stands up: of these, a column that must not buckle with half its weight more on top."""
    changes = {"emitter.strands": 40, "emitter.length_variation": 0.5}
    solver = held(20.0, 20, UP, **changes)
    (words,) = advice.softness(solver.scene, solver.groom)
    weak = 20.0 * (solver.lengths.reshape(-1)[:40] * 20) ** 3 > BUCKLING / SAFETY
    assert 0 < weak.sum() < 40
    assert f"{weak.sum()} of 40 strands" in words
    assert "rod.radius" in words
    upright = held(100.0, 20, UP)
    assert "up to 19.2 times" in advice.softness(upright.scene, upright.groom)[0]


@pytest.mark.parametrize("segments", [10, 40])
def test_how_stiff_does_not_depend_on_the_number_of_particles(segments: int) -> None:
    # as soft as a column that carries so much of its weight along itself
    for way, share in [(UP, 1.0), (LEVEL, np.sin(TILT)), (RISING, np.cos(np.arctan2(1, 0.6) - TILT))]:
        assert stiffer(held(1e3, segments, way), 1e3) == pytest.approx(1e3 * SAFETY * share / BUCKLING, rel=0.02)
    # the falling one would not buckle, but be bent too far
    turned = 1e4 * np.cos(np.radians(45)) / 6
    assert stiffer(held(1e4, segments, FALLING), 1e4) == pytest.approx(turned / (2 * TURNS), rel=0.03)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("angle", "turns"), [(20.0, 1.5), (35.0, 4.0), (60.0, 2.0)])
def test_curls_stay_and_find_back(angle: float, turns: float, way: tuple[float, float, float]) -> None:
    curl = {"emitter.curl_angle": angle, "emitter.curl_turns": turns}
    for gamma in (10.0, 1e4):
        for dt in (1 / 240, 1 / 24, 0.5):
            solver = held(gamma, 20, way, **curl)
            start = first(solver)
            for i in range(48):
                solver.step((i + 1) * dt, dt)
                assert np.abs(first(solver) - start).max() <= 1e-6
        keys = [{"time": 0}, {"time": 0.25, "rotation": [0, 0, 45]}, {"time": 0.5}, {"time": 99}]
        gravity = {"gravity": {"acceleration": [0, -PULL, 0]}}
        solver = held(gamma, 20, way, **{**curl, "emitter.keys": keys, "rules": ["emitter_motion", gravity]})
        take_steps(solver, 24, 30 * 24)
        assert np.abs(first(solver) - start).max() <= 3e-3  # of a tight coil, what turns about its axis comes last


G = 9.81


def curls(
    fps: int, particles: int, turns: int, angle: int, gamma: float, more: str = "", keys: str = "", length: float = 0.3
) -> RodSolver:
    """Sixteen curls with Γ = ρ A g L³ / B."""
    radius = 0.002 * length
    young = 4000 * G * length**3 / gamma / radius**2
    return rod_of(
        f"rod: {{rest: shape, density: 1000, radius: {radius}, young: {young}, torsion: 0.7, drag: 0, "
        f"damping: 0{more}}}\ntime: {{fps: {fps}}}\nemitter: {{shape: {{kind: disc, radius: 0.06}}, strands: 16, "
        f"particles: {particles}, length: {length}, jitter: 20, rotation: [30, 0, 0], curl_turns: {turns}, "
        f"curl_angle: {angle}{keys}}}\nrules: [gravity, emitter_motion]\n"
    )


def energy(solver: RodSolver) -> NDArray[np.float64]:
    """(16,) of motion and weight, over m g L."""
    mass, rows = solver.mass.astype(float), solver.state.velocity
    velocity = rows.reshape(*rows.shape[:2], 3, -1).transpose(0, 3, 1, 2).reshape(-1, rows.shape[1], 3)[:16]
    kinetic = 0.5 * (mass[:, None] * solver.groom.emitted(velocity.astype(float)) ** 2).sum((1, 2))
    potential = G * (mass * solver.particles()[:, 1:, 1].astype(float)).sum(1)
    return np.asarray((kinetic + potential) / (G * solver.groom.lengths[0] * mass.sum()))


HINGED = ", root: hinged"


@pytest.mark.parametrize(
    ("fps", "particles", "turns", "angle", "gamma", "more", "length"),
    [
        (24, 64, 12, 75, 1000, HINGED, 0.3),
        (48, 16, 6, 75, 100, "", 0.3),
        (24, 32, 12, 56, 300, "", 0.3),
        (24, 64, 6, 56, 300, "", 0.3),
        (96, 64, 6, 56, 300, "", 0.3),
        (24, 64, 6, 56, 300, "", 1.0),
        (24, 20, 1, 30, 0.34, HINGED, 0.05),
        (96, 20, 1, 30, 0.34, HINGED, 0.05),
        (24, 26, 3, 56, 2.7, HINGED, 0.1),
        (96, 26, 3, 56, 2.7, HINGED, 0.1),
        (24, 64, 6, 56, 74, HINGED, 0.3),
    ],
)
def test_energy_does_not_grow(
    fps: int, particles: int, turns: int, angle: int, gamma: float, more: str, length: float
) -> None:
    """With 1.2 to 20 segments a turn. It grew by .06 to 150 m g L where twist or frames run away."""
    solver = curls(fps, particles, turns, angle, gamma, more, length=length)
    begin, most = energy(solver), -math.inf
    for _ in each_step(solver, fps, 4 * fps):
        most = max(most, float((energy(solver) - begin).max()))
    assert most < 0.01


def test_a_run_of_hinged_curls_goes_on_from_its_state() -> None:
    keys = ", keys: [{time: 0}, {time: 1, rotation: [0, 200, 60]}]"
    require_same_after_restart(*(curls(24, 13, 3, 56, 2.7, HINGED, keys, 0.1) for _ in range(2)))
