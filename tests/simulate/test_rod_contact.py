"""Rods against solids: depth, friction, and what is carried along."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strandcli.simulate.rod.solver import RodSolver
from tests.simulate.test_rod import PULL, scene
from tests.simulate.test_rod_motion import first, solver_of


def against(solids: list[dict[str, Any]], gamma: float = 10.0, double: bool = False, **changes: Any) -> RodSolver:
    rules: list[Any] = ["emitter_motion", {"gravity": {"acceleration": [0, -PULL, 0]}}, "collision"]
    changes = {"emitter.strands": 20, "emitter.jitter": 30.0, "rules": rules, **changes}
    return solver_of(scene(gamma, solids=solids, **changes), double)


def ball(radius: float, *position: float, **more: Any) -> dict[str, Any]:
    return {"kind": "sphere", "radius": radius, "position": list(position), **more}


CASES = {
    "root on the surface, strand inside": [ball(0.3, 0.3, 0, 0)],
    "strand through the centre": [ball(0.2, 0.5, 0, 0)],
    "two that overlap": [ball(0.2, 0.5, -0.1, 0), ball(0.2, 0.65, -0.1, 0.1)],
    "smaller than half a segment": [ball(0.04, 0.5, -0.3, 0)],
    "capsule": [{"kind": "capsule", "radius": 0.15, "length": 1, "position": [0.5, -0.4, 0], "rotation": [90, 0, 0]}],
    "box": [{"kind": "box", "size": [0.4, 0.4, 0.4], "position": [0.5, -0.4, 0]}],
    "plane": [{"kind": "plane", "position": [0, -0.3, 0]}],
}


@pytest.mark.parametrize("dt", [1 / 240, 1 / 24, 0.5])
@pytest.mark.parametrize("case", CASES)
def test_nothing_is_left_inside(case: str, dt: float) -> None:
    solver = against(CASES[case])
    for i in range(100):
        solver.step((i + 1) * dt, dt)
        errors = solver.errors(1)
        assert errors["nonfinite"] == 0
        assert errors["stretch_max"] <= 1e-6  # type: ignore[operator]
        assert i == 0 or errors["penetration_max"] <= 1e-6  # type: ignore[operator]
        if dt <= 1 / 24:
            assert errors["residual_max"] <= 1e-3  # type: ignore[operator]


@pytest.mark.parametrize("radius", [0.3, 3.0])
def test_a_ball_that_swallows_the_root_is_survived(radius: float) -> None:
    solver = against([ball(radius, 0, 0, 0)])
    for i in range(60):
        solver.step((i + 1) / 24, 1 / 24)
    errors = solver.errors(1)
    assert errors["nonfinite"] == 0
    assert errors["stretch_max"] <= 1e-6  # type: ignore[operator]
    if radius < 1:  # the tip gets out
        assert np.linalg.norm(first(solver)[-1]) >= radius - 1e-6


def carried(friction: float, shift: float) -> float:
    """How far the tip of a strand goes with a ball, so large that it is nearly flat, which moves under it sideways by
    so many metres in 4 seconds."""
    keys = [{"time": 0, "position": [0.5, -50.2, 0]}, {"time": 4, "position": [0.5, -50.2, shift]}]
    one = {"emitter.strands": 1, "emitter.jitter": 0.0, "rod.friction": friction, "rod.damping": 0.01}
    solver = against([{"kind": "sphere", "radius": 50, "keys": keys}], 100.0, **one)
    for i in range(96):
        solver.step((i + 1) / 24, 1 / 24)
    assert first(solver)[-1, 1] < -0.15
    return float(first(solver)[-1, 2])


def test_friction_carries_strands_along() -> None:
    # the ball has its top further on now: without friction the strand slides a little downhill, the other way
    assert -0.05 < carried(0.0, 0.2) < 0
    assert abs(carried(1.0, 0.0)) < 1e-3
    assert carried(1.0, 0.2) > 0.05


def test_a_ball_that_moves_pushes() -> None:
    keys = [{"time": 0, "position": [0.6, 0, -1]}, {"time": 2, "position": [0.6, 0, 1]}]
    solver = against([{"kind": "sphere", "radius": 0.3, "keys": keys}])
    for i in range(48):
        solver.step((i + 1) / 24, 1 / 24)
        errors = solver.errors(i + 2)
        assert errors["residual_max"] <= 1e-3  # type: ignore[operator]
        assert solver._depths((i + 1) / 24)[0] <= 1e-6  # type: ignore[operator]
