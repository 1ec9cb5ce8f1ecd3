"""Grooms that hang still as they are emitted: at the first frame, for as long as one looks, and again after a shake."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_simulate_rod import PULL, scene
from test_simulate_rod_motion import first, solver_of

from strandcli.simulate.rod import RodSolver
from strandcli.simulate.sag_free import SAFETY, TILT, TURNS, hold

LEVEL, UP, HANGING, RISING, FALLING = (1, 0, 0), (0, 1, 0), (0, -1, 0), (1, 0.6, 0), (1, -1, 0)
WAYS = [LEVEL, UP, HANGING, RISING, FALLING]
BUCKLING = 7.83735  # Γ of an upright column that buckles under its own weight


def held(gamma: float, segments: int, way: tuple[float, float, float], **changes: Any) -> RodSolver:
    changes = {"rod.rest": "sag_free", "emitter.particles": segments + 1, **changes}
    return solver_of(scene(gamma, direction=way, **changes))


def stiffer(solver: RodSolver, gamma: float) -> float:
    """How many times as stiff as the material the first strand is."""
    return float(solver.stiffness[0, 0] * solver.own_lengths[0, 0] ** 4 / (PULL / gamma))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("segments", [1, 2, 10, 20, 32, 999])
@pytest.mark.parametrize("gamma", [10.0, 100.0, 1e4])
def test_nothing_moves(gamma: float, segments: int, way: tuple[float, float, float]) -> None:
    for dt in (1 / 240, 1 / 24, 0.5):
        solver = held(gamma, segments, way)
        start = first(solver)
        for i in range(8 if segments > 32 else 96):
            solver.step((i + 1) * dt, dt)
            assert np.abs(first(solver) - start).max() <= 1e-6


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("gamma", "angle", "rate"), [(10.0, 30, 24), (1e4, 30, 24), (1e4, 120, 24), (1e4, 30, 240)])
def test_it_finds_back_when_its_root_has_turned(
    gamma: float, angle: float, rate: int, way: tuple[float, float, float]
) -> None:
    keys = [{"time": 0}, {"time": 0.25, "rotation": [0, 0, angle]}, {"time": 0.5}, {"time": 99}]
    gravity = {"gravity": {"acceleration": [0, -PULL, 0]}}
    solver = held(gamma, 10, way, **{"emitter.keys": keys, "rules": ["emitter_motion", gravity]})
    start = first(solver)
    away = 0.0
    for i in range(10 * rate):
        solver.step((i + 1) / rate, 1 / rate)
        away = max(away, float(np.abs(first(solver) - start).max()))
    assert away > 0.1
    assert np.abs(first(solver) - start).max() <= 1e-5


def test_strands_that_can_hold_their_shape_stay_as_they_are() -> None:
    for gamma, way in [(1e4, HANGING), (100.0, (0.05, -1, 0)), (10.0, LEVEL), (5.0, UP)]:
        solver = held(gamma, 10, way)
        assert stiffer(solver, gamma) == pytest.approx(1, rel=1e-5)
        assert solver.warnings == []


def test_strands_that_cannot_are_made_stiffer_and_say_so() -> None:
    """One of two strands stands up: of these, a column that must not buckle with half its weight more on top."""
    changes = {"emitter.strands": 40, "emitter.length_variation": 0.5}
    solver = held(20.0, 20, UP, **changes)
    (words,) = solver.warnings
    weak = 20.0 * (solver.lengths.reshape(-1)[:40] * 20) ** 3 > BUCKLING / SAFETY
    assert 0 < weak.sum() < 40
    assert f"{weak.sum()} of 40 strands" in words
    assert "rod.radius" in words
    assert held(100.0, 20, UP).warnings[0].count("up to 19.2 times") == 1


@pytest.mark.parametrize("segments", [10, 40])
def test_how_stiff_does_not_depend_on_the_number_of_particles(segments: int) -> None:
    # as soft as a column that carries so much of its weight along itself
    for way, share in [(UP, 1.0), (LEVEL, np.sin(TILT)), (RISING, np.cos(np.arctan2(1, 0.6) - TILT))]:
        assert stiffer(held(1e3, segments, way), 1e3) == pytest.approx(1e3 * SAFETY * share / BUCKLING, rel=0.02)
    # half a turn less a third: a falling one is only bent too far
    turned = 1e4 * np.cos(np.radians(45)) / 6
    assert stiffer(held(1e4, segments, FALLING), 1e4) == pytest.approx(turned / TURNS, rel=0.03)


def test_a_strand_without_rigidity_is_given_some() -> None:
    level = np.tile([1.0, 0.0, 0.0], (5, 1, 1))
    found = hold(level, np.ones(5), np.ones(5), np.zeros(1), np.array([[0.0, -1.0, 0.0]]))
    assert found.stiffness[0] > 0
    assert np.isfinite(found.bends).all()


def test_forces_balance() -> None:
    """Edge by edge, a crooked strand of unequal masses and joints: weight, tension and the moments at both ends."""
    draw = np.random.default_rng(5)
    edges = np.array([[1.0, 0.2, 0.0]]) + 0.4 * draw.normal(size=(7, 3, 3))
    edges /= np.linalg.norm(edges, axis=2, keepdims=True)
    mass, joint = draw.uniform(0.5, 1, 7), draw.uniform(0.2, 1, 7)
    pull = np.tile([0.3, -2.0, 0.1], (3, 1))
    found = hold(edges, mass, joint, np.full(3, 50.0), pull)
    moments = found.stiffness[:, None] * joint[:, None, None] * found.bends
    after = np.concatenate([moments[1:], np.zeros((1, 3, 3))])
    weight = np.cumsum(mass[::-1])[::-1][:, None, None] * pull
    np.testing.assert_allclose(found.tension[..., None] * edges + moments - after, weight, atol=1e-12)
