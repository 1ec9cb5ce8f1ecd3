"""Grooms that hang still as they are emitted: at the first frame, for as long as one looks, and again after a shake."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rod_kit import each_step, take_steps
from strandcli.simulate import advice
from strandcli.simulate.rod.rest_shape import SAFETY, TILT, TURNS, hold
from strandcli.simulate.rod.solver import RodSolver
from tests.simulate.test_rod import PULL, scene
from tests.simulate.test_rod_motion import first, solver_of

LEVEL, UP, HANGING, RISING, FALLING = (1, 0, 0), (0, 1, 0), (0, -1, 0), (1, 0.6, 0), (1, -1, 0)
WAYS = [LEVEL, UP, HANGING, RISING, FALLING]
BUCKLING = 7.83735  # Γ of an upright column that buckles under its own weight


def held(gamma: float, segments: int, way: tuple[float, float, float], **changes: Any) -> RodSolver:
    changes = {"rod.rest": "sag_free", "emitter.particles": segments + 1, **changes}
    return solver_of(scene(gamma, direction=way, **changes))


def stiffer(solver: RodSolver, gamma: float) -> float:
    """How many times as stiff as the material the first strand is."""
    return float(solver.material.stiffness[0, 0] * solver.material.lengths[0, 0] ** 4 / (PULL / gamma))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("gamma", "segments"), [(10.0, 10), (100.0, 10), (1e4, 1), (1e4, 2), (1e4, 10), (1e4, 20), (1e4, 32), (1e4, 999)]
)
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


def test_a_strand_without_rigidity_is_given_some() -> None:
    way = np.array([[1.0, 0.0, 0.0]])
    found = hold(way, np.tile(way, (5, 1, 1)), np.ones(5), np.ones(5), np.zeros(1), 4.0, np.array([[0.0, -1.0, 0.0]]))
    assert found.stiffness[0] > 0
    assert np.isfinite(found.bends).all()


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
