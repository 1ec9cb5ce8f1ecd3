"""Runs of rods never stop: what stops a run is looked for after every step of the matrix's wind."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from strandcli.simulate import health, solver_of
from strandcli.simulate.rod.solver import RodSolver
from strandcli.study.stress import drive, scenes
from strandcli.study.stress.axes import AXES, Case


def troubles(labels: dict[str, str]) -> list[str]:
    """What stops a run of all starts together, step by step."""
    cases = [Case.of("rod", {**labels, "start": start}) for start in AXES["start"]]
    times = scenes.times_of(cases[0])
    scene = scenes.scene_of(cases[0], times)
    solver = solver_of(scene)(scene, scenes.groom_of(cases))
    found, past = [], 0.0
    for step, time in enumerate(times):
        solver.step(float(time), float(time) - past)
        past = float(time)
        trouble = health.examine(solver, step + 1, solver.errors(step + 1))
        if trouble is not None:
            found.append(f"{labels}: {trouble.message}")
    return found


@pytest.mark.parametrize("dt", AXES["dt"])
def test_no_wind_of_the_matrix_stops_a_run(dt: str) -> None:
    found: list[str] = []
    for B, emitter in product(("0", "1", "1e6"), AXES["emitter"]):
        found += troubles({"dt": dt, "B": B, "emitter": emitter, "wind": "gale"})
    for B, contact in product(("0", "1e6"), ("inside", "through", "moving")):
        found += troubles({"dt": dt, "B": B, "contact": contact, "wind": "gale"})
    assert found == []


@pytest.mark.parametrize("labels", [{"B": "0", "gamma": "1e4"}, {"tip": "1e3"}, {"tip": "1e3", "gamma": "1e4"}])
def test_loads_and_tips_too_great_for_single_precision_are_moved_in_double(labels: dict[str, str]) -> None:
    """In single precision these never moved: no iteration came to an end, and every step was given up."""
    assert troubles({"dt": "10", **labels}) == []


def test_a_case_that_would_stop_a_run_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    lost = 1.5 * health.RESIDUAL_MOST
    monkeypatch.setattr(RodSolver, "strand_residuals", lambda self: np.full(self.strands, lost))
    labels = {"dt": "10", "wind": "gale"}  # a step so long that the residual itself is told and not judged
    (outcome,) = drive.run([Case.of("rod", labels)])
    assert outcome.metrics["stopped"] == 1
    assert len(troubles(labels)) == len(scenes.times_of(Case.of("rod", labels)))
    monkeypatch.setattr(RodSolver, "strand_residuals", lambda self: np.full(self.strands, np.nan))
    (outcome,) = drive.run([Case.of("rod", labels)])
    assert outcome.metrics["stopped"] == 1
