"""Rods against solids: depth, friction, and what is carried along."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from strandcli.constants import VECTOR
from strandcli.simd import broadcast, load3, pointer, store
from strandcli.simulate.kernels import contact_shapes
from strandcli.simulate.rod import RodSolver
from tests.simulate.test_rod import PULL, scene
from tests.simulate.test_rod_motion import first, solver_of

LANES = VECTOR // 8


def against(solids: list[dict[str, Any]], gamma: float = 10.0, **changes: Any) -> RodSolver:
    rules: list[Any] = ["emitter_motion", {"gravity": {"acceleration": [0, -PULL, 0]}}, "collision"]
    changes = {"emitter.strands": 20, "emitter.jitter": 30.0, "rules": rules, **changes}
    return solver_of(scene(gamma, solids=solids, **changes))


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


def test_balls_alone_and_balls_among_others_are_one_contact() -> None:
    """The kernel for balls, a row at a time, and that for all solids give the same strands."""
    one = {"emitter.strands": 1, "emitter.jitter": 0.0, "rod.friction": 0.0}
    far = {"kind": "box", "size": [1, 1, 1], "position": [0, -50, 0]}
    shapes = []
    for solids in ([ball(0.2, 0.5, -0.3, 0.01)], [ball(0.2, 0.5, -0.3, 0.01), far]):
        solver = against(solids, **one)
        for i in range(24):
            solver.step((i + 1) / 24, 1 / 24)
        shapes.append(first(solver))
    np.testing.assert_allclose(*shapes, atol=1e-4)


def test_a_ball_that_moves_pushes() -> None:
    keys = [{"time": 0, "position": [0.6, 0, -1]}, {"time": 2, "position": [0.6, 0, 1]}]
    solver = against([{"kind": "sphere", "radius": 0.3, "keys": keys}])
    for i in range(48):
        solver.step((i + 1) / 24, 1 / 24)
        errors = solver.errors(i + 2)
        assert errors["residual_max"] <= 1e-3  # type: ignore[operator]
        assert solver._depths((i + 1) / 24)[0] <= 1e-6  # type: ignore[operator]


@njit(error_model="numpy")
def radius_for_first_edges(given, length, r, out):
    """The kernel, which has no way in from Python: ``given`` (6, LANES) are roots as seen from a ball's centre and unit
    edges, ``out`` (LANES,) how far from the centre their ends are kept."""
    rows = pointer(given)
    x, y, z = load3(rows, 0, LANES)
    d = load3(rows, 3 * LANES, LANES)
    x, y, z = x + length * d[0], y + length * d[1], z + length * d[2]
    size = broadcast(rows, length)
    edges = contact_shapes.Edges(d, d, size, size, True, True)
    store(pointer(out), 0, contact_shapes.clearance_radius((x, y, z), r, edges))


def test_an_edge_from_a_surface_is_a_tangent_whichever_way_its_beginning_is_rounded() -> None:
    given = np.zeros((6, LANES))
    given[1] = np.resize([1 - 1e-6, 1.0, 1 + 1e-6], LANES)
    given[3:5] = [[0.8], [-0.6]]
    out = np.empty(LANES)
    radius_for_first_edges(given, 0.3, 1.0, out)
    np.testing.assert_allclose(out, np.hypot(1.0, 0.3), atol=1e-3)


@pytest.mark.parametrize("particles", [11, 31])
def test_a_particle_that_is_newly_touched_is_pushed_by_no_more_than_its_own_depth(particles: int) -> None:
    """A limp strand lies on one ball, and another comes by slowly: alone no push moves a particle by as much as a fifth
    of a segment in a step. (The first ball's push says nothing of what a push at the second one does.)"""
    keys = [{"time": 2, "position": [0.62, -0.9, 0.2], "ease": "linear"}, {"time": 4, "position": [0.62, -0.9, -0.2]}]
    solver = against(
        [ball(0.2, 0.35, -0.25, 0), ball(0.1, 0.62, -0.9, 0.2, keys=keys)],
        1e4,
        **{"emitter.strands": 4, "emitter.jitter": 0, "emitter.particles": particles, "rod.drag": 2.0},
    )
    dt, worst, both = 1 / 240, 0.0, 0
    for i in range(960):
        solver.step((i + 1) * dt, dt)
        push = np.linalg.norm(solver.state.push[0].reshape(particles - 1, 3, -1)[:, :, 0].astype(float), axis=1)
        worst = max(worst, push.max() * dt**2 * (particles - 1))
        both += bool(push.any() and np.ptp(np.flatnonzero(push)) > 3)
    assert both > 100  # pushed at places that are far from each other
    assert worst < 0.2
