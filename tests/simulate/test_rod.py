"""Rods at other precisions, kernels and thread counts, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import strandcli
from rod_kit import each_step, take_steps
from strand_kit import groom_of, scene_of
from strandcli.compiling import runtime
from strandcli.errors import UsageError
from strandcli.groom.emit import emit
from strandcli.simulate import advice
from strandcli.simulate.rod import solver as rod_solver
from strandcli.simulate.rod import step as rod_step
from strandcli.simulate.rod.kernels import work_queue
from strandcli.simulate.rod.kernels.step import run
from strandcli.simulate.rod.solver import RodSolver

PULL = 9.81


def scene(gamma: float, *, direction: tuple[float, float, float] = (1, 0, 0), **changes: Any) -> Any:
    """One rod of a metre in a field of 9.81 m/s², of the rigidity that Γ asks for."""
    young = 4 * 1000.0 * PULL / gamma / 0.01**2  # E R² / (4 ρ) = g L³ / Γ with R = 1 cm, ρ = 1000 kg/m³
    settings = {
        "solver": "rod",
        "emitter": {
            "shape": {"kind": "disc", "radius": 1e-6},
            "direction": list(direction),
            "strands": 1,
            "particles": 10,
            "length": 1.0,
            "length_variation": 0.0,
            "jitter": 0.0,
        },
        "rules": [{"gravity": {"acceleration": [0, -PULL, 0]}}],
        "solids": [],
        "rod": {"density": 1000.0, "radius": 0.01, "young": young, "drag": 2.0, "damping": 0.0},
        **changes,
    }
    return strandcli.load("minimal", settings=settings)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "changes",
    [
        {"rod": {"young": 1e13, "density": 1e-9, "radius": 1e9}},
        pytest.param(
            {"emitter.length": 2e-5, "emitter.length_variation": 1.0, "emitter.strands": 300}, marks=pytest.mark.long
        ),
    ],
    ids=["hardest matter", "shortest strands"],
)
def test_rods_of_any_stiffness_stay_straight(changes: dict[str, Any]) -> None:
    one = scene(10.0, **changes)
    solver = RodSolver(one, emit(one.emitter, one.seed))
    take_steps(solver, 24, 5)
    found = solver.errors(1)
    assert found["nonfinite"] == 0
    assert found["residual_max"] < 1e-5
    strands = solver.particles().astype(float)
    ways = strands[:, -1] - strands[:, 0]
    assert (np.abs(ways[:, 1]) < 1e-4 * np.linalg.norm(ways, axis=1)).all()


def test_any_number_of_threads_gives_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rod_step, "SEGMENTS_A_THREAD", 1000)
    one = scene(10.0, **{"emitter.strands": 300, "emitter.jitter": 60.0})
    results = []
    for threads in (1, 2):
        runtime.start(threads)
        solver = RodSolver(one, emit(one.emitter, one.seed))
        assert len(solver.kernel.scratch) == threads
        take_steps(solver, 30, 10)
        results.append(solver.positions.copy())
    np.testing.assert_array_equal(*results)


def test_a_step_takes_no_more_threads_than_its_caller_has(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of other frames are at work on these."""
    monkeypatch.setattr(rod_step, "SEGMENTS_A_THREAD", 10)
    one = scene(10.0, **{"emitter.strands": 20})
    runtime.start(2)
    solver = RodSolver(one, emit(one.emitter, one.seed))
    runtime.start(1)
    asked: list[int] = []
    run_workers = work_queue.run_workers

    def watched(code: int, given: Any, queue: Any, workers: int) -> None:
        asked.append(workers)
        run_workers(code, given, queue, workers)

    monkeypatch.setattr(work_queue, "run_workers", watched)
    solver.step(1 / 30, 1 / 30)
    assert asked == [1]
    runtime.start(2)
    solver.step(2 / 30, 1 / 30)
    assert asked == [1, 2]


def test_nothing_is_compiled_for_strands_that_do_not_move(monkeypatch: pytest.MonkeyPatch) -> None:
    """A first frame without a pre-roll, or positions from a cache; a step of weeks asks for a kernel of its own."""
    asked: list[str] = []

    def address(function: Any, arguments: Any) -> int:
        asked.append(str(arguments[0].edges.dtype))
        raise NotImplementedError

    monkeypatch.setattr(work_queue, "address", address)
    one = scene(10.0, **{"time.fps": 1e-6, "time.preroll": 2.5})
    solver = RodSolver(one, emit(one.emitter, one.seed))
    solver.advance(1)
    solver.take(7, solver.particles())
    solver.errors(7)
    assert asked == []
    with pytest.raises(NotImplementedError):
        solver.advance(2)
    assert asked == ["float64"]


def test_rules_of_other_packages_are_refused_by_name() -> None:
    from strandcli.scene.model import RuleUse

    one = scene(10.0)
    object.__setattr__(one, "rules", (*one.rules, RuleUse("vortex", None, "vortex")))
    with pytest.raises(UsageError, match=r"vortex.*solver: thesis"):
        RodSolver(one, emit(one.emitter, one.seed))


def test_long_strands_are_as_exact_as_short_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    one = scene(1e3, **{"emitter.strands": 64, "emitter.jitter": 60.0, "emitter.particles": 200})

    def fallen() -> tuple[np.ndarray, float]:
        solver = RodSolver(one, emit(one.emitter, one.seed))
        left, films = 0.0, []
        for _ in each_step(solver, 24, 18):
            left = max(left, float(solver.errors(1)["residual_max"] or 0.0))
            films.append(solver.particles().astype(float))
        return np.array(films), left

    films, left = fallen()
    # | |e| − 1 | is half of | |e|² − 1 |; single edges may be off by more, by their share of 199 and not of 32
    bound = rod_solver.TOLERANCES[False] / 2
    assert bound < left <= 1.01 * bound * 199 / 32
    monkeypatch.setitem(rod_solver.TOLERANCES, False, 1e-7)
    exact, left = fallen()
    assert left < 1e-6
    off = np.linalg.norm(films - exact, axis=3).max(2)  # of a metre, which strands are long
    assert off.max() < 1.3e-3
    assert off.mean() < 6e-5


def test_the_compiled_step_can_be_kept_in_the_cache() -> None:
    """Machine code that holds addresses of this process is compiled anew by every run."""
    one = scene(10.0)
    RodSolver(one, emit(one.emitter, one.seed)).step(1 / 24, 1 / 24)
    assert run.overloads
    assert not any(made.library.has_dynamic_globals for made in run.overloads.values())


def test_settings_of_rods_beside_another_solver_are_warned_of() -> None:
    idle = scene_of("rod: {end: pinned, drag: 2}\n")
    assert advice.warnings(idle, groom_of(idle)) == [
        "rod.end, rod.drag: ignored by solver thesis; set solver: rod to have them act"
    ]
    for fine in ("solver: rod\nrod: {drag: 2}\n", "rod: {drag: 1}\n"):
        scene = scene_of(fine)
        assert advice.warnings(scene, groom_of(scene)) == []
