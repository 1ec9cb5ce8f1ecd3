"""Rods in motion and on solids: energy, order in the step, roots put elsewhere, and the limit of contact."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rod_kit import each_step, take_steps
from strandcli.errors import UsageError
from strandcli.simulate.rod.solver import RodSolver
from tests.simulate.test_rod import PULL, scene, solver_of


def first(solver: RodSolver) -> np.ndarray:
    """(particles, 3) of the first strand in the solver's own precision."""
    rows = solver.state.positions[0, 1:]
    return rows.reshape(len(rows), 3, -1)[:, :, 0].astype(float)


def energy(solver: RodSolver) -> float:
    """Kinetic, of weight and of bending, over m g L."""
    x = first(solver)
    v = solver.state.velocity[0].reshape(len(x) - 1, 3, -1)[:, :, 0].astype(float)
    mass, joint = solver.mass.astype(float), solver.material.joint.astype(float)
    length = float(solver.material.lengths[0, 0])
    edges = np.diff(x, axis=0) / length
    clamp = solver.drive.directions[0].reshape(3, -1)[:, 0].astype(float)
    bends = np.diff(np.concatenate([clamp[None], edges]), axis=0)
    bending = float(solver.material.stiffness[0, 0]) * length**2 / 2 * (joint[:, None] * bends**2).sum()
    total = (mass[:, None] * v**2).sum() / 2 + PULL * (mass * x[1:, 1]).sum() + bending
    return total / (PULL * mass.sum() * length * len(edges))


FREE = {"rod.drag": 0.0, "rod.damping": 0.0}


@pytest.mark.parametrize("gamma", [1.0, 1e4])
def test_energy_does_not_grow(gamma: float) -> None:
    solver = solver_of(scene(gamma, **FREE))
    start = energy(solver)
    for _ in each_step(solver, 60, 300):
        assert energy(solver) - start <= 1e-6


def test_order_in_the_step() -> None:
    def end(rate: int) -> np.ndarray:
        solver = solver_of(scene(10.0, **FREE, **{"emitter.particles": 6}), double=True)
        take_steps(solver, rate, rate // 2)
        return first(solver)

    best = end(1920)
    errors = [np.abs(end(rate) - best).max() for rate in (60, 120, 240)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders.min() > 1.4
    assert orders.max() < 2.1


def test_double_precision_keeps_lengths_to_its_last_digits() -> None:
    solver = solver_of(scene(10.0), double=True)
    take_steps(solver, 24, 30)
    edges = np.linalg.norm(np.diff(first(solver), axis=0), axis=1)
    np.testing.assert_allclose(edges, 1 / 9, rtol=1e-12)
    assert solver.errors(1)["stretch_max"] <= 1e-12  # type: ignore[operator]


@pytest.mark.parametrize("gamma", [1.0, 10.0, 100.0])
def test_rest_is_still_and_the_same_at_any_rate(gamma: float) -> None:
    shapes = []
    for rate in (2, 24, 240):
        solver = solver_of(scene(gamma))
        seen = []
        for _ in each_step(solver, rate, max(21 * rate, 60)):
            seen.append(first(solver))
        assert np.ptp(np.array(seen[-rate:]), axis=0).max() <= 1e-6
        shapes.append(seen[-1])
    assert np.abs(shapes - shapes[-1]).max() <= 1e-4


def moving(gamma: float, keys: list[dict[str, Any]], double: bool = False, **changes: Any) -> RodSolver:
    rules = ["emitter_motion", {"gravity": {"acceleration": [0, -PULL, 0]}}]
    changes = {"emitter.strands": 20, "emitter.jitter": 60.0, "emitter.keys": keys, **changes}
    return solver_of(scene(gamma, rules=rules, **changes), double)


def test_a_strand_falls_in_a_moving_frame_as_in_one_at_rest() -> None:
    """Roots at a steady speed change nothing but where everything is: Galileo's principle."""
    keys = [{"time": 0, "position": [0, 0, 0], "ease": "linear"}, {"time": 4, "position": [2.4, 0, 1.6]}]
    settings = {**FREE, "emitter.strands": 1}
    still = moving(10.0, [{"time": 0}], True, **settings)
    carried = moving(10.0, keys, True, **settings)
    carried.state.velocity[...] = np.repeat([0.6, 0.0, 0.4], carried.state.velocity.shape[-1] // 3)
    for i in range(60):
        for solver in (still, carried):
            solver.step((i + 1) / 60, 1 / 60)
    np.testing.assert_allclose(first(carried) - first(carried)[0], first(still), atol=1e-6)


def test_a_teleport_carries_the_shape_along() -> None:
    keys = [{"time": 0}, {"time": 1.0}, {"time": 1.0001, "position": [100, 0, 0]}, {"time": 9, "position": [100, 0, 0]}]
    solver = moving(10.0, keys)
    take_steps(solver, 24, 24)
    before = solver.particles() + np.array([100, 0, 0])
    solver.step(25 / 24, 1 / 24)
    # at rest again, and what is left of a fall from rest in one step
    assert np.abs(solver.particles() - before).max() < 2 * PULL / 24**2
    assert solver.residual() < 1e-3  # type: ignore[operator]


def test_a_stiff_hinged_rod_is_a_physical_pendulum() -> None:
    """ω² = 3 g / (2 L); a clamped one stays where it is."""
    changes = {**FREE, "direction": (0.1, -1.0, 0.0)}
    held, solver = (solver_of(scene(1e-2, **changes, **{"rod.root": root})) for root in ("clamped", "hinged"))
    seen = []
    for i in range(240):
        for one in (held, solver):
            one.step((i + 1) / 60, 1 / 60)
        seen.append(first(solver)[-1, 0])
    x = np.array(seen)
    through = np.flatnonzero(x[1:] * x[:-1] < 0)
    times = through + x[through] / (x[through] - x[through + 1])
    half = float(np.diff(times).mean()) / 60
    assert half == pytest.approx(np.pi / np.sqrt(1.5 * PULL), rel=0.01)
    assert np.abs(x[180:]).max() == pytest.approx(0.1, rel=0.03)
    assert abs(first(held)[-1, 0] - 0.1) < 2e-3


def test_a_hinged_root_holds_no_strand_up() -> None:
    with pytest.raises(UsageError, match=r"rod\.root: hinged roots cannot balance gravity"):
        solver_of(scene(1.0, **{"rod.root": "hinged", "rod.rest": "sag_free"}))


def test_material_and_length_decide_how_a_strand_hangs() -> None:
    """Thin tips and unequal lengths: a strand of half the length and an eighth of the weight moment sags less."""
    one = scene(30.0, **{"rod.tip": 0.3})
    thin = solver_of(one)
    thick = solver_of(scene(30.0))
    for i in each_step(thin, 24, 240):
        thick.step((i + 1) / 24, 1 / 24)
    # less weight far out: the clamp carries less, and the middle of the strand hangs higher
    assert first(thin)[4, 1] > first(thick)[4, 1]


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
