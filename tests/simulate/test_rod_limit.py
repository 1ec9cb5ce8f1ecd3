"""Rods in contact have a limit under refinement: at rest, as they slide, after an impact, begun inside of a solid."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rod_kit import each_step, take_steps
from strandcli.simulate.rod.solver import RodSolver
from tests.simulate.test_rod import PULL, scene, solver_of
from tests.simulate.test_rod_motion import first

SOLIDS: dict[str, dict[str, Any]] = {
    "sphere": {"kind": "sphere", "radius": 0.2},
    "capsule": {"kind": "capsule", "radius": 0.15, "length": 1},
    "box": {"kind": "box", "size": [0.4, 0.4, 0.4]},
    "plane": {"kind": "plane"},
}
PLACES = {
    "sphere": ([0.5, -0.35, 0.03], [0, 0, 0]),
    "capsule": ([0.5, -0.35, 0.0], [80, 0, 0]),
    "box": ([0.5, -0.4, 0.0], [0, 0, 0]),
    "plane": ([0.0, -0.3, 0.0], [0, 0, 0]),
}
CALM = {"rod.drag": 4.0, "rod.damping": 0.01}


def over(
    solids: list[dict[str, Any]], gamma: float, segments: bool = False, double: bool = False, **changes: Any
) -> RodSolver:
    """One rod, which falls on solids from a little above level."""
    rules: list[Any] = [
        "emitter_motion", {"gravity": {"acceleration": [0, -PULL, 0]}}, {"collision": {"segments": segments}},
    ]  # fmt: skip
    return solver_of(scene(gamma, solids=solids, rules=rules, **{"direction": (1, 0.2, 0), **CALM, **changes}), double)


def rising(kind: str) -> dict[str, Any]:
    """A solid that begins to rise and to move on after two seconds."""
    place, rotation = PLACES[kind]
    ways = [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (3.0, 0.09, 0.3)]
    keys = [
        {"time": time, "position": [place[0] + x, place[1] + y, place[2]], "rotation": rotation} for time, x, y in ways
    ]
    return {**SOLIDS[kind], "keys": keys}


def still(kind: str) -> dict[str, Any]:
    place, rotation = PLACES[kind]
    return {**SOLIDS[kind], "position": place, "rotation": rotation}


def after(solver: RodSolver, seconds: float, rate: int) -> np.ndarray:
    take_steps(solver, rate, round(seconds * rate))
    return first(solver)


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("kind", SOLIDS)
def test_a_strand_that_slides_over_a_solid_is_of_first_order_at_least(kind: str, friction: float) -> None:
    def end(rate: int) -> np.ndarray:
        return after(over([rising(kind)], 30.0, double=True, **{"rod.friction": friction}), 2.5, rate)

    best = end(3840)
    # from 30 to 1920: between them errors change their sign
    coarse, fine = (np.abs(end(rate) - best).max() for rate in (30, 1920))
    assert coarse < 0.006
    assert fine < max(coarse / 2**6, 3e-5)


@pytest.mark.parametrize("segments", [False, True])
@pytest.mark.parametrize("kind", SOLIDS)
def test_a_strand_leans_on_a_solid_in_the_same_way_at_any_step(kind: str, segments: bool) -> None:
    shapes = [after(over([still(kind)], 30.0, segments, **{"rod.friction": 0.0}), 12, rate) for rate in (24, 240)]
    np.testing.assert_allclose(*shapes, atol=1e-4)


@pytest.mark.parametrize("rate", [24, 60, 300])
def test_nothing_bounces(rate: int) -> None:
    """A pendulum that swings against a wall."""
    wall = {"kind": "box", "size": [1, 4, 4], "position": [-0.5, 0, 0]}
    settings = {"emitter.particles": 2, "rod.drag": 0.0, "rod.damping": 0.0}
    solver = over([wall], 1e7, direction=(0.5, -1, 0), **settings)
    seen = []
    for _ in each_step(solver, rate, 3 * rate):
        seen.append(first(solver)[-1, 0])
    there = int(np.argmax(np.array(seen) < 1e-6))
    assert there > 0
    assert max(seen[there:]) < 0.01


@pytest.mark.parametrize("rate", [60, 1000])
def test_what_begins_inside_of_a_solid_leaves_it_at_rest(rate: int) -> None:
    solver = over([{"kind": "sphere", "radius": 0.25, "position": [0.5, 0.02, 0]}], 10.0, direction=(1, 0, 0))
    solver.step(1 / rate, 1 / rate)
    assert solver._depths(0.0)[0] <= 1e-6  # type: ignore[operator]
    # the strand is bent around the ball, and springs back as any that is let go; a jump of 0.2 m in the step would be
    # 12 m/s at 60 Hz and 200 m/s at 1,000
    assert np.abs(solver.state.velocity).max() < 8


@pytest.mark.parametrize("rate", [24, 60, 240])
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize(("place", "rotation"), [([0.5, -0.4, 0], [0, 0, 0]), ([0.3, -0.45, 0], [0, 0, 40])])
def test_segments_across_an_edge_come_to_rest(
    place: list[float], rotation: list[float], friction: float, rate: int
) -> None:
    box = {**SOLIDS["box"], "position": place, "rotation": rotation}
    solver = over([box], 100.0, True, **{"rod.friction": friction, "emitter.particles": 11})
    after(solver, 12, rate)
    assert solver.state.force.any()
    seen = []
    for i in range(12 * rate, 13 * rate):
        solver.step((i + 1) / rate, 1 / rate)
        seen.append(first(solver))
    assert np.ptp(np.array(seen), axis=0).max() < 1e-3


def test_a_plane_carries_what_lies_on_it() -> None:
    """A chain that hangs down 0.3 of its length and lies on a plane with the rest."""
    solver = over([still("plane")], 1e5, direction=(1, 0, 0), **{"rod.friction": 0.0, "emitter.particles": 21})
    x = after(solver, 12, 60)
    mass = solver.mass.astype(float)
    force = solver.state.force[0].reshape(len(x) - 1, 3, -1)[:, :, 0] / (PULL * mass.sum())
    np.testing.assert_allclose(force[:, [0, 2]], 0, atol=1e-5)
    assert force[:, 1].min() >= 0
    np.testing.assert_array_equal(force[:, 1] > 0, x[1:, 1] < -0.3 + 1e-6)
    assert force[:, 1].sum() == pytest.approx(0.7, abs=0.03)
