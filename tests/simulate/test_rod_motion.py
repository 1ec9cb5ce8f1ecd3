"""Rods in motion: energy, order in the step, and roots that are put elsewhere."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strand_kit import scene_of
from strandcli.errors import UsageError
from strandcli.groom.emit import emit
from strandcli.simulate.rod.kernels.begin import BLEND, GAIN, OLD_GAIN, VELOCITY_RATE
from strandcli.simulate.rod.solver import RodSolver
from tests.simulate.test_rod import PULL, scene


def solver_of(one: Any, double: bool = False) -> RodSolver:
    return RodSolver(one, emit(one.emitter, one.seed), double)


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


def test_positions_taken_from_elsewhere_are_drawn_the_same() -> None:
    """The row before the root has the bits that it had."""
    keys = "keys: [{time: 0}, {time: 1, position: [0.3, 0.1, 0], rotation: [20, 100, 30]}]"
    turning = scene_of(
        f"emitter: {{strands: 300, particles: 5, length: 0.3, jitter: 30, {keys}}}\nsolver: rod\n"
        "time: {fps: 24, frames: 9}\nrules: [emitter_motion, gravity]\n"
    )
    groom = emit(turning.emitter, turning.seed)
    run, taken = RodSolver(turning, groom), RodSolver(turning, groom)
    for frame in (1, 2, 6):
        run.advance(frame)
        taken.take(frame, run.particles())
        np.testing.assert_array_equal(taken.positions, run.positions)


def crests(y: np.ndarray) -> np.ndarray:
    """Heights of the maxima, by parabolas."""
    i = np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] >= y[2:])) + 1
    a, b, c = y[i - 1], y[i], y[i + 1]
    return b - (c - a) ** 2 / (8 * (a - 2 * b + c))


def greatest_root(turn: float) -> float:
    """Greatest factor of a step of an oscillation with ω Δt = ``turn``, by the numbers of BDF2 as the kernel has them:
    u = û + h v with û = u/3, v = v̂ − h' ω² x, and x_{n+1} = x_n + u."""
    h, g = 2 / 3, 1 / VELOCITY_RATE
    ahead = np.array([1 + GAIN, -GAIN - OLD_GAIN, OLD_GAIN])  # of v_n, v_{n−1}, v_{n−2}
    step = np.zeros((5, 5))  # of x, v, v_{n−1}, v_{n−2}, u
    # v' (1 + g h turn²) = v̂ − g turn² (x + u / 3)
    step[1] = np.array([-g * turn**2, *ahead, -g * turn**2 / 3]) / (1 + g * h * turn**2)
    step[4] = h * step[1] + np.array([0, 0, 0, 0, 1 / 3])
    step[0] = step[4] + np.array([1, 0, 0, 0, 0])
    step[2, 1] = step[3, 2] = 1
    return float(np.abs(np.linalg.eigvals(step)).max())


def test_bdf2_is_stable_at_any_step_and_loses_little() -> None:
    assert max(map(greatest_root, np.geomspace(1e-2, 1e4, 200))) < 1
    for turn in (0.1, 0.2):
        assert 1 - greatest_root(turn) == pytest.approx((1 - BLEND) / 4 * turn**4, rel=0.2)


FREE = {"rod.drag": 0.0, "rod.damping": 0.0}


def test_a_pendulum_keeps_its_amplitude() -> None:
    solver = solver_of(scene(1e7, direction=(0.3, -1.0, 0.0), **FREE, **{"emitter.particles": 2}))
    swing = []
    for i in range(600):
        solver.step((i + 1) / 60, 1 / 60)
        swing.append(first(solver)[-1, 0])
    tops = crests(np.array(swing))
    assert len(tops) >= 4
    assert 0.999 < (tops[-1] / tops[0]) ** (1 / (len(tops) - 1)) <= 1.0


@pytest.mark.parametrize("gamma", [1.0, 1e4])
def test_energy_does_not_grow(gamma: float) -> None:
    solver = solver_of(scene(gamma, **FREE))
    start = energy(solver)
    for i in range(300):
        solver.step((i + 1) / 60, 1 / 60)
        assert energy(solver) - start <= 1e-6


def test_order_in_the_step() -> None:
    def end(rate: int) -> np.ndarray:
        solver = solver_of(scene(10.0, **FREE, **{"emitter.particles": 6}), double=True)
        for i in range(rate // 2):
            solver.step((i + 1) / rate, 1 / rate)
        return first(solver)

    best = end(1920)
    errors = [np.abs(end(rate) - best).max() for rate in (60, 120, 240)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders.min() > 1.4
    assert orders.max() < 2.1


def test_double_precision_keeps_lengths_to_its_last_digits() -> None:
    solver = solver_of(scene(10.0), double=True)
    for i in range(30):
        solver.step((i + 1) / 24, 1 / 24)
    edges = np.linalg.norm(np.diff(first(solver), axis=0), axis=1)
    np.testing.assert_allclose(edges, 1 / 9, rtol=1e-12)
    assert solver.errors(1)["stretch_max"] <= 1e-12  # type: ignore[operator]


@pytest.mark.parametrize("gamma", [1.0, 10.0])
def test_rest_is_still_and_the_same_at_any_rate(gamma: float) -> None:
    shapes = []
    for rate in (24, 240):
        solver = solver_of(scene(gamma), double=True)
        seen = []
        for i in range(21 * rate):
            solver.step((i + 1) / rate, 1 / rate)
            if i >= 20 * rate:
                seen.append(first(solver))
        assert np.ptp(np.array(seen), axis=0).max() <= 1e-6
        shapes.append(seen[-1])
    assert np.abs(shapes[0] - shapes[1]).max() <= 1e-4


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
    for i in range(24):
        solver.step((i + 1) / 24, 1 / 24)
    before = solver.particles() + np.array([100, 0, 0])
    solver.step(25 / 24, 1 / 24)
    # at rest again, and what is left of a fall from rest in one step
    assert np.abs(solver.particles() - before).max() < 2 * PULL / 24**2
    assert solver.residual() < 1e-3  # type: ignore[operator]


@pytest.mark.parametrize("gamma", [10.0, 1e4])
def test_a_root_that_turns_over_in_one_step(gamma: float) -> None:
    keys = [{"time": 0}, {"time": 0.5}, {"time": 0.5001, "rotation": [0, 180, 0]}, {"time": 9, "rotation": [0, 180, 0]}]
    solver = moving(gamma, keys)
    for i in range(36):
        solver.step((i + 1) / 24, 1 / 24)
        assert solver.residual() <= 1e-3  # type: ignore[operator]
        errors = solver.errors(1)
        assert errors["nonfinite"] == 0
        assert errors["stretch_max"] <= 1e-6  # type: ignore[operator]


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


@pytest.mark.parametrize("particles", [2, 3, 4, 11, 21])
def test_any_number_of_segments(particles: int) -> None:
    solver = solver_of(scene(10.0, **{"emitter.particles": particles}))
    for i in range(60):
        solver.step((i + 1) / 24, 1 / 24)
        assert solver.residual() <= 1e-3  # type: ignore[operator]
    assert np.isfinite(first(solver)).all()


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 1, 0), (0.5, 0.5, 0.2)])
def test_a_sag_free_rod_stays_where_it_is(direction: tuple[float, float, float]) -> None:
    changes = {"rod.rest": "sag_free", "rod.tip": 0.5, "emitter.strands": 50, "emitter.jitter": 20.0}
    solver = solver_of(scene(10.0, direction=direction, **{**changes, "emitter.length_variation": 0.3}))
    start = solver.positions.copy()
    solver.step(1 / 24, 1 / 24)
    assert np.abs(solver.positions - start).max() <= 1e-6


def test_material_and_length_decide_how_a_strand_hangs() -> None:
    """Thin tips and unequal lengths: a strand of half the length and an eighth of the weight moment sags less."""
    one = scene(30.0, **{"rod.tip": 0.3})
    thin = solver_of(one)
    thick = solver_of(scene(30.0))
    for i in range(240):
        thin.step((i + 1) / 24, 1 / 24)
        thick.step((i + 1) / 24, 1 / 24)
    # less weight far out: the clamp carries less, and the middle of the strand hangs higher
    assert first(thin)[4, 1] > first(thick)[4, 1]
