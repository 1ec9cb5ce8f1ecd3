"""Sweeps over solvers that are made up, whose errors are known; axes and their settings; advice."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from strand_kit import scene_of
from strandcli.errors import MismatchError, UsageError
from strandcli.study import advice, axes, find, sweep
from strandcli.study.motion import Motion
from strandcli.study.points import CELL, Point
from strandcli.study.references import References
from strandcli.study.sweep import changed
from study_kit import Synthetic, made


def test_every_run_is_counted() -> None:
    steps: list[str] = []
    totals: list[int] = []
    study = sweep.run(Synthetic, sweep.Request(), None, steps.append, totals.append)
    assert totals == [2 + 32]
    assert len(steps) == 34
    assert len(study.points) == 32


def test_the_cheapest_under_an_error_is_recommended() -> None:
    study = made(0.1)
    assert [one["parameters"]["solver"] for one in study.recommended] == ["one", "two"]
    for one in study.recommended:
        fit = [
            point for point in study.points if point.solver == one["parameters"]["solver"] and point.error["tip"] <= 0.1
        ]  # type: ignore[operator]
        assert one["seconds"] == min(point.seconds for point in fit)
        assert one["error"] <= 0.1
    assert made(1e-5).recommended == []
    assert made(0.1, margin=0.2).recommended == []


def test_without_an_error_a_ladder_is_climbed() -> None:
    rungs = [(one["parameters"]["solver"], one["max_error"]) for one in made().recommended]
    assert rungs == sorted(rungs, key=lambda pair: (pair[0], -pair[1]))
    assert {"one", "two"} == {solver for solver, _ in rungs}
    settings = [json.dumps(one["parameters"]) for one in made().recommended]
    assert len(settings) == len(set(settings))


def test_the_registry_has_every_axis_by_its_name() -> None:
    assert {"motion", "reference"} <= set(axes())
    for name, axis in axes().items():
        assert find(name) == axis
    with pytest.raises(UsageError, match="axes are"):
        find("colour")
    with pytest.raises(UsageError, match="solvers are"):
        sweep.chosen_solvers(sweep.Request(solvers=("mass_spring",)))


def test_parameters_can_be_chosen() -> None:
    wishes = sweep.Request(name="elastica", solvers=("rod",), substeps=(2,), iterations=(3,), particles=(8, 9))
    chosen = References(wishes)
    assert chosen.settings() == [
        {"solver": "rod", "emitter.particles": n, "rod.iterations": 3, "dt": 1 / 48} for n in (8, 9)
    ]


HANGING = """
time: {frames: 6, fps: 24, preroll: 1}
emitter: {strands: 40, particles: 5, length: 0.5, length_variation: 0.4, jitter: 20}
rules: [gravity, elasticity]
"""


def validate_iterations(count: int) -> int:
    """As many as a preset may ask for, and no more: one more is refused."""
    assert scene_of(f"rod: {{iterations: {count}}}").rod.iterations == count
    with pytest.raises(UsageError, match=r"rod\.iterations"):
        scene_of(f"rod: {{iterations: {count + 1}}}")
    return count


def motion(**wishes: Any) -> Motion:
    return Motion(sweep.Request(scene=scene_of(HANGING), name="hanging", **wishes))


def test_the_limit_is_sought_twice_as_fine_as_all_that_is_tried() -> None:
    opened = motion(solvers=("thesis",), substeps=(1, 4), particles=(5, 9), strands=10)
    finer = opened.finer(opened.solvers[0])
    assert [parameters["time.substeps"] for parameters in finer] == [2, 4, 8]
    assert [parameters["emitter.particles"] for parameters in finer] == [5, 9, 17]
    assert opened.references == 3
    assert len(opened.lengths) == 10
    assert opened.frames[0] == 1
    assert opened.frames[-1] == 6


def test_iterations_are_few_and_as_many_as_the_preset_allows() -> None:
    opened = motion(solvers=("rod",), substeps=(1, 2), particles=(5,))
    found = [(one["rod.iterations"], one["time.substeps"]) for one in opened.settings()]
    assert found == [(2, 1), (2, 2), (200, 1), (200, 2)]
    assert opened.finer(opened.solvers[0])[-1]["rod.iterations"] == 400
    own = Motion(sweep.Request(scene=changed(opened.scene, {"rod.iterations": 700}), solvers=("rod",)))
    assert {one["rod.iterations"] for one in own.settings()} == {2, 700}
    finest = own.finer(own.solvers[0])[-1]
    assert validate_iterations(finest["rod.iterations"]) == 1000
    kept = motion(solvers=("rod",), iterations=(3,))
    assert {one["rod.iterations"] for one in kept.settings()} == {3}
    fixed = motion(solvers=("rod",), fixed=frozenset({"rod.iterations", "wind.strength"}))
    assert {one["rod.iterations"] for one in fixed.settings()} == {200}


def test_cells_are_varied_where_they_are_named() -> None:
    """The limit has cells half as wide as the least."""
    text = HANGING.replace("[gravity,", "[gravity, interaction: {density: 1.0e+4},") + "solver: rod\n"
    wishes = {"solvers": ("rod",), "substeps": (1,), "iterations": (2,), "particles": (5,)}
    opened = Motion(sweep.Request(scene=scene_of(text), name="hanging", cells=(0.1, 0.2), **wishes))
    assert [one[CELL] for one in opened.settings()] == [0.1, 0.2]
    assert [one[CELL] for one in opened.finer("rod")] == [0.2, 0.1, 0.05]
    opened.prepare(lambda text: None)
    point = opened.measure(opened.settings()[0])
    assert point.sizes["cell"] == 0.1
    assert 0 < point.error["median"] < 0.5
    with pytest.raises(UsageError, match="--cells: hanging lists no rule interaction"):
        motion(cells=(0.1,))


def test_frames_keep_within_the_span() -> None:
    assert max(motion(span=0.1).frames) == 3
    assert max(motion(span=3600.0).frames) == 6


def test_strands_of_a_study_are_the_first_of_the_groom() -> None:
    few, all_of_them = motion(strands=7), motion(strands=40)
    np.testing.assert_array_equal(few.lengths, all_of_them.lengths[:7])


def test_the_thesis_falls_slower_in_smaller_steps_and_is_told_to_have_no_limit() -> None:
    """Its speed is g Δt (thesis §2): refining it changes the motion, and the study has to say so."""
    study = sweep.run(
        find("motion"),
        sweep.Request(scene=scene_of(HANGING), name="hanging", solvers=("thesis",), substeps=(1, 2), strands=20),
        0.01,
    )
    assert study.margins["thesis"] > 0.05
    assert study.recommended == []
    still = scene_of(HANGING.replace("[gravity, elasticity]", "[elasticity]"))
    request = sweep.Request(scene=still, name="still", solvers=("thesis",), substeps=(1, 2), strands=20)
    at_rest = sweep.run(find("motion"), request, 0.01)
    assert at_rest.margins["thesis"] == pytest.approx(0, abs=1e-5)
    assert all(point.error["max"] == pytest.approx(0, abs=1e-5) for point in at_rest.points)


def test_panels_are_studied_one_at_a_time() -> None:
    scene = scene_of("panels: [{label: a}, {label: b, set: {seed: 2}}]\n")
    with pytest.raises(UsageError, match="panel"):
        Motion(sweep.Request(scene=scene, name="two"))


def test_rules_that_rods_do_not_take_are_told() -> None:
    from strandcli.scene.model import RuleUse

    scene = scene_of(HANGING)
    object.__setattr__(scene, "rules", (*scene.rules, RuleUse("vortex", None, "vortex")))
    opened = Motion(sweep.Request(scene=scene, name="odd", solvers=("rod",)))
    assert [one["solver"] for one in opened.absent] == ["rod"]
    assert "vortex" in opened.absent[0]["why"]


def data(margin: float | None) -> dict[str, Any]:
    points = [
        {
            "parameters": {"solver": "rod", "time.substeps": n, "emitter.particles": 9},
            "seconds": n,
            "error": {"median": e},
        }
        for n, e in ((1, 0.03), (2, 0.008), (4, 0.002), (8, None))
    ]
    return {"metric": "median", "margin": margin, "points": points}


def test_advice_is_the_cheapest_that_is_sure() -> None:
    chosen = advice.choose(data(0.001), "hair", "rod", 0.01, [], True)
    assert chosen.settings == {"time.substeps": 2, "emitter.particles": 9}
    assert "earlier study" in chosen.text()
    assert advice.choose(data(0.003), "hair", "rod", 0.01, [], True).settings["time.substeps"] == 4
    fixed = advice.choose(data(0.001), "hair", "rod", 0.01, ["emitter.particles"], False)
    assert fixed.settings == {"time.substeps": 2}
    for margin, words in ((0.02, "known to 2 % only"), (None, "no limit"), (0.0001, "nearest is 0.21 %")):
        with pytest.raises(MismatchError, match=words):
            advice.choose(data(margin), "hair", "rod", 0.001, [], False)


def test_finer_settings_are_tried_where_the_usual_will_not_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A made-up solver of second order in its substeps, whose limit is known."""
    asked: list[sweep.Request] = []

    def study(axis: Any, request: sweep.Request, *rest: Any) -> sweep.Study:
        asked.append(request)
        points = [
            Point({"solver": "rod", "time.substeps": n}, n, {"median": 0.04 / n**2}, "rod")
            for n in request.substeps or (1, 2, 4)
        ]
        told = {"limits": {"rod": {"converges": True}}}
        return sweep.Study("motion", "made", "", "median", "", told, {"rod": 0.0}, points, [], [], [])

    monkeypatch.setattr(advice, "folder", lambda: tmp_path)
    monkeypatch.setattr(sweep, "run", study)
    scene = changed(scene_of(HANGING), {"solver": "rod"})

    def advised(most: float, fixed: Sequence[str] = ()) -> advice.Advice:
        return advice.advise(scene, "made", most, fixed, lambda text: None, lambda runs: None)

    assert advised(0.01).settings == {"time.substeps": 2}
    assert len(asked) == 1
    found = advised(1e-3)
    assert found.settings == {"time.substeps": 8}
    assert (asked[1].substeps, asked[1].particles) == ((8, 16, 32), (5, 9))
    assert len(asked) == 2  # the first round was cached
    assert advised(1e-3).reused
    with pytest.raises(MismatchError, match="nearest"):
        advised(1e-7)
    with pytest.raises(MismatchError):
        advised(1e-3, ["time.substeps"])
    assert (asked[-1].substeps, asked[-1].fixed) == (None, {"time.substeps"})


def test_advice_of_motion_follows_from_what_moves_the_strands() -> None:
    scene = scene_of(HANGING)
    same = scene_of(HANGING + "image: {size: [30, 20]}\nmaterial: {diffuse: 0.9}\n")
    assert advice.motion_of(scene, {}) == advice.motion_of(same, {})
    assert advice.motion_of(scene, {}) != advice.motion_of(scene_of(HANGING + "seed: 3\n"), {})
    assert advice.motion_of(scene, {}) != advice.motion_of(scene, {"time.substeps": (2,)})


def test_a_study_is_cached_by_what_it_follows_from_and_the_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(advice, "folder", lambda: tmp_path)
    assert advice.cached("motion", [1], lambda: {"a": 1}) == ({"a": 1}, False)
    assert advice.cached("motion", [1], lambda: {"a": 2}) == ({"a": 1}, True)
    assert advice.cached("motion", [2], lambda: {"a": 2}) == ({"a": 2}, False)
    for path in tmp_path.iterdir():
        path.write_text("{")  # cut off
    assert advice.cached("motion", [1], lambda: {"a": 3}) == ({"a": 3}, False)
    monkeypatch.setattr(advice, "_sources", lambda: "other code")
    assert advice.cached("motion", [1], lambda: {"a": 4}) == ({"a": 4}, False)
    (tmp_path / "file").touch()
    monkeypatch.setattr(advice, "folder", lambda: tmp_path / "file" / "folder")
    assert advice.cached("motion", [1], lambda: {"a": 5}) == ({"a": 5}, False)


def test_orders_of_a_synthetic_solver_are_found() -> None:
    found = {(one["line"], one["in"]): one["order"] for one in made().orders if one["metric"] == "tip"}
    assert found["one", "dt"] == pytest.approx(1)
    assert found["two", "dt"] == pytest.approx(2)
    assert found["two", "segment"] == pytest.approx(2)
