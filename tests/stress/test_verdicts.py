"""What the stability matrix measures, and what it makes of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from strandcli.scene.model import SphereSolid
from strandcli.simulate import health
from strandcli.simulate.contact.forces import Forces
from strandcli.simulate.rod.solver import RodSolver
from strandcli.simulate.rules import registry
from strandcli.simulate.thesis.solver import ThesisSolver
from strandcli.study.stress import drive, run, scenes
from strandcli.study.stress.matrix import AXES, Case, case_named


def meter(**solids: Any) -> drive.Meter:
    """Two strands of two segments of half a metre."""
    case = case_named("rod/contact=through/n=2")
    scene = scenes.scene_of(case, scenes.times_of(case))
    ball = SphereSolid(radius=0.25, position=(0.5, 0.3, 0.0))
    return drive.Meter(replace(scene, solids=(ball, *solids.get("more", ()))), np.full(2, 0.5), 1.0, touching=True)


def strands(*tips: tuple[float, float, float]) -> np.ndarray:
    """(strands, 3, 3) with their middles at (½, 0, 0)."""
    return np.array([[(0, 0, 0), (0.5, 0, 0), tip] for tip in tips], np.float32)


def test_what_is_measured_is_what_was_made() -> None:
    one = meter()
    one.look(strands((1, 0, 0), (0.5, 0.4, 0)), 0.0, np.array([0.25, 0.125]))
    first, second = one.metrics(slice(0, 1)), one.metrics(slice(1, 2))
    assert first == {"nonfinite": 0, "stretch": 0, "penetration": 0, "residual": 0.25, "stopped": 0}
    assert second["stretch"] == pytest.approx(0.2, abs=1e-6)
    assert second["penetration"] == pytest.approx(0.15, abs=1e-6)
    one.look(strands((1, 0, 0), (np.nan, 0, 0)), 0.0, np.array([0.125, 0.0]))
    assert one.metrics(slice(0, 1))["nonfinite"] == 0
    assert one.metrics(slice(1, 2))["nonfinite"] == 1
    assert one.metrics(slice(None))["penetration"] == pytest.approx(0.15, abs=1e-6)
    assert one.metrics(slice(None))["residual"] == 0.25
    one.look(strands((1, 0, 0), (1, 0, 0)), 0.0, np.array([0.0, np.nan]))
    assert np.isnan(one.metrics(slice(None))["residual"])
    assert one.metrics(slice(None))["stopped"] == one.metrics(slice(1, 2))["stopped"] == 1
    assert one.metrics(slice(0, 1))["residual"] == 0.25


def test_whole_segments_are_judged_where_a_scene_keeps_them_out() -> None:
    """A strand across a ball between two particles: .05 deep; of its first segment only what its root is not."""
    scene = meter().scene
    whole = registry()["collision"].Parameters(segments=True)
    rules = tuple(replace(use, parameters=whole) if use.name == "collision" else use for use in scene.rules)
    one = drive.Meter(replace(scene, rules=rules), np.full(2, 0.5), 1.0, touching=True)
    x = np.array([[(0, 0.1, 0), (0.25, 0.1, 0), (0.75, 0.1, 0)], [(0.5, 0.2, 0), (0.5, 0.6, 0), (0.9, 0.6, 0)]])
    one.look(x.astype(np.float32), 0.0, None)
    assert one.metrics(slice(0, 1))["segment_penetration"] == pytest.approx(0.05, abs=1e-6)
    assert one.metrics(slice(1, 2))["segment_penetration"] == pytest.approx(0.1, abs=1e-6)
    assert "segment_penetration" not in meter().metrics(slice(None))
    assert run.beyond("segment_penetration", 0.05)


def test_rounding_of_coordinates_far_away_is_no_stretch_and_more_is() -> None:
    far = np.float32(1e6)
    one = meter()
    shifted = strands((1, 0, 0), (1, 0, 0)) + np.array([far, 0, 0], np.float32)
    shifted[1, 2, 0] += np.float32(0.5)
    one.look(shifted, 0.0, None)
    assert one.metrics(slice(0, 1))["stretch"] == 0
    assert one.metrics(slice(1, 2))["stretch"] > 0.5


def test_overlapping_solids_are_told_and_not_judged() -> None:
    one = meter(more=[SphereSolid(radius=0.25, position=(0.5, 0.2, 0.0))])
    one.look(strands((0.5, 0.4, 0), (1, 0, 0)), 0.0, None)
    metrics = one.metrics(slice(None))
    assert metrics["overlap"] > 0.1
    assert not run.beyond("overlap", metrics["overlap"])


def judged(metrics: dict[str, float], name: str = "rod/dt=0.5", **options: Any) -> run.Verdict:
    return run.judge(name, {}, metrics, **options)


def test_verdicts() -> None:
    good = {"nonfinite": 0.0, "stretch": 1e-6, "residual": 1e-3}
    assert judged(good).verdict == "pass"
    for metric, value in (("nonfinite", 1.0), ("stretch", 1.1e-6), ("residual", np.nan)):
        bad = judged({**good, metric: value})
        assert bad.verdict == "fail"
        assert bad.failed == (metric,)
        assert metric in bad.why
    loose = judged({"residual": 7.0, "stretch": 0.0}, unjudged={"residual": "steps are long", "stretch": "soft"})
    assert (loose.verdict, loose.why) == ("pass", "residual 7, not held to <= 0.001: steps are long")
    assert judged({"residual": 1e-4}, unjudged={"residual": "steps are long"}).why == ""
    assert judged({}, error="ValueError: no").why == "ValueError: no"
    assert judged({}, error="ValueError: no").verdict == "fail"
    assert judged({}, absent="no mass").verdict == "not_represented"
    assert judged({"stretch": 1 / 3}).as_dict()["metrics"] == {"stretch": 0.3333}


def test_only_what_is_listed_is_expected() -> None:
    name = "thesis/contact=through"
    assert judged({"penetration": 0.2}, name).verdict == "expected_failure"
    assert "elasticity" in judged({"penetration": 0.2}, name).why
    both = judged({"penetration": 0.2, "nonfinite": 1.0}, name)
    assert both.verdict == "fail"
    assert "nonfinite" in both.why
    assert judged({"penetration": 0.2}, "rod/contact=through").verdict == "fail"
    assert not [name for name, metric in run.expected("thesis")[1] if metric in ("nonfinite", "exception")]


def test_every_failure_that_is_expected_is_one_of_a_case_of_the_matrix() -> None:
    reasons, listed = run.expected("thesis")
    assert all(reasons.values())
    known = run.tasks(["thesis"]) + run.tasks(["thesis"], quick=True)
    assert {name for name, _ in listed} <= {name for task in known for name in (case.name for case in task)}
    passed = [run.Verdict(name, {}, {}, "pass") for name in ("thesis/contact=through", "thesis")]
    assert run.Result(("thesis",), passed, 0.0).passed_after_all == ["thesis/contact=through"]


def test_a_solver_that_raises_or_leaves_nan_fails_its_case(monkeypatch: pytest.MonkeyPatch) -> None:
    task = run.named("thesis/start=random")
    assert {one.verdict for one in run.perform(task)} == {"pass"}
    step = ThesisSolver.step

    def spoil(self: ThesisSolver, time: float, dt: float) -> None:
        step(self, time, dt)
        if dt > 0:
            self.positions[0, 3, 1] = np.nan  # the strand in the second lane

    monkeypatch.setattr(ThesisSolver, "step", spoil)
    assert [one.verdict for one in run.perform(task)] == ["pass", "fail", "pass", "pass", "pass"]

    def explode(self: ThesisSolver, time: float, dt: float) -> None:
        raise ZeroDivisionError("bug")

    monkeypatch.setattr(ThesisSolver, "step", explode)
    found = run.perform(task)
    assert {one.why for one in found} == {"ZeroDivisionError: bug"}
    assert {one.verdict for one in found} == {"fail"}


def test_a_step_of_no_length_that_moves_something_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    step = ThesisSolver.step
    monkeypatch.setattr(ThesisSolver, "step", lambda self, time, dt: step(self, time, dt or 1e-3))
    assert "moved_by_nothing" in run.perform(run.named("thesis"))[0].why


def test_a_residual_is_pinned_on_the_strand_that_has_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def residuals(self: ThesisSolver) -> np.ndarray:
        return np.where(np.abs(self.particles()[:, 1:, 2]).max(1) > 1e-3, 0.5, 1e-5)  # the random start's is great

    monkeypatch.setattr(ThesisSolver, "strand_residuals", residuals)
    found = {
        one.case.label("start"): one.metrics["residual"]
        for one in drive.run([case_named("thesis").with_labels(start=start) for start in AXES["start"]])
    }
    assert found == {"straight": 1e-5, "zero": 1e-5, "coincident": 1e-5, "folded": 1e-5, "random": 0.5}


def test_what_a_solver_has_not_is_never_a_pass() -> None:
    assert {one.verdict for one in run.perform(run.named("thesis/tip=1e-3"))} == {"not_represented"}


def test_pinned_tips_are_watched(monkeypatch: pytest.MonkeyPatch) -> None:
    (found,) = run.perform(run.named("rod/emitter=flip/end=pinned"))
    assert found.verdict == "pass"
    assert found.metrics["pinned_off"] < 1e-3
    monkeypatch.setattr("strandcli.simulate.rod.setup.HEAVY", 1.0)
    assert "pinned_off" in run.perform(run.named("rod/emitter=flip/end=pinned"))[0].failed


@pytest.mark.parametrize(
    "name",
    [
        "rod/gamma=0/emitter=teleport/start=coincident/between=grid-fine/twist=sag-free/end=pinned/torsion=0.7",
        "rod/dt=1e-4/B=1e-6/wind=gale/emitter=teleport/start=coincident/between=grid-fine/twist=sag-free/end=pinned",
        "rod/dt=1e-4/gamma=1e4/emitter=flip/start=coincident/between=grid-fine/twist=sag-free/end=pinned",
        "rod/dt=1e-4/gamma=7.7/emitter=shake/between=grid-coarse/twist=coil/end=pinned/root=hinged/torsion=0.7",
    ],
)
def test_taut_strands_with_pinned_tips_stay_so_a_hundred_lengths_away(name: str) -> None:
    """Positions are rounded more there, which tips had no way to go by."""
    (found,) = run.perform(run.named(name))
    assert (found.verdict, found.why) == ("pass", "")


def test_forces_of_contact_that_no_step_can_carry_do_not_end_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forces for which iterations still find lengths leave strands speeds of 2.5 km/s, which then no step between two
    ends can carry."""
    solve = Forces.solve

    def wild(self: Forces, found: Any, forces: Any, solver: Any) -> float:
        moved = solve(self, found, forces, solver)
        forces *= 1e14
        return moved

    monkeypatch.setattr(Forces, "solve", wild)
    name = "rod/dt=noisy/B=1e-2/emitter=flip/n=2/start=random/between=thick/end=pinned"
    assert "stopped" not in run.perform(run.named(name))[0].failed


def test_a_case_that_would_stop_a_run_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    lost = 1.5 * health.RESIDUAL_MOST
    monkeypatch.setattr(RodSolver, "strand_residuals", lambda self: np.full(self.strands, lost))
    labels = {"dt": "10", "wind": "gale"}  # a step so long that the residual itself is told and not judged
    (outcome,) = drive.run([Case.of("rod", labels)])
    assert outcome.metrics["stopped"] == 1
    monkeypatch.setattr(RodSolver, "strand_residuals", lambda self: np.full(self.strands, np.nan))
    (outcome,) = drive.run([Case.of("rod", labels)])
    assert outcome.metrics["stopped"] == 1
