"""Every run reports its own error, and one that goes wrong stops there: which strand, whose doing, what to do."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import bad_rules
import strandcli
from cli_runs import Runner, report
from strandcli.errors import SimulationError
from strandcli.output import png
from strandcli.run import pipeline
from strandcli.simulate import health, rules
from strandcli.simulate.solver import Solver

PRESET = """\
time: {frames: 6, fps: 10, substeps: 2}
emitter: {strands: 150, particles: 5, length: 0.6, jitter: 10, shape: {kind: sphere, radius: 0.3}}
image: {size: [48, 40]}
camera: {position: [0, 0, 3]}
lights: [{kind: directional, shadow: {model: "off"}}]
rules: [gravity: {acceleration: [0, -1, 0]}, RULE, elasticity]
"""


@pytest.fixture(autouse=True)
def _outsiders(monkeypatch: pytest.MonkeyPatch) -> None:
    for rule in (bad_rules.rooted, bad_rules.growing):
        monkeypatch.setitem(rules._registry, rule.name, rule)


@pytest.fixture
def run(run: Runner) -> Runner:
    Path("bad.yaml").write_text(PRESET.replace("RULE", "rooted: {after: 0.25}"))
    Path("grow.yaml").write_text(PRESET.replace("RULE, elasticity", "elasticity, growing: {after: 0.15}"))
    return run


def test_a_rule_that_makes_nan_is_named_with_frame_and_strand(run: Runner) -> None:
    line = run.refused("render", "bad.yaml", "-o", "a", code=1)
    (frame,) = pipeline.render(strandcli.load("bad.yaml"), [3], draw=False, keep_positions=True)
    strand = int(np.argmax((frame.positions[:, 1:, 0] > 0).any(1)))  # the rule begins beyond x = 0
    assert f"frame 4: strand {strand}, particle" in line
    assert "under the rules " in line
    assert "time.substeps" in line
    assert "--keep-going" in line
    assert sorted(os.listdir("a")) == [
        "frame_0001.png",
        "frame_0002.png",
        "frame_0003.png",
        "report.html",
        "report.json",
    ]
    data = report("a")
    assert data["status"] == "failed"
    assert {key: data["failure"][key] for key in ("frame", "strand")} == {"frame": 4, "strand": strand}
    assert "rooted" in data["failure"]["cause"]
    assert all(entry["error"]["nonfinite"] == 0 for entry in data["frames"])


def test_it_stops_where_it_went_wrong_and_not_where_it_is_looked_at(run: Runner) -> None:
    assert "frame 4: " in run("render", "bad.yaml", "-o", "a", "-f", "6").error()
    assert "frame 4: " in run("simulate", "bad.yaml", "-o", "p", "-f", "6").error()


def test_a_strand_that_is_pulled_out_of_all_bounds_stops_the_run_before_numbers_overflow(run: Runner) -> None:
    line = run("render", "grow.yaml", "-o", "a").error()
    assert "is stretched by" in line
    data = report("a")
    assert data["failure"]["frame"] == 3
    assert data["frames"][-1]["error"]["stretch_max"] <= health.STRETCH_MOST["thesis"]


def test_strands_that_no_rule_holds_together_may_stretch(run: Runner) -> None:
    Path("loose.yaml").write_text(Path("grow.yaml").read_text().replace("elasticity, ", ""))
    assert run("render", "loose.yaml", "-o", "a", "-f", "1-4").code == 0
    assert report("a")["frames"][-1]["error"]["stretch_max"] > health.STRETCH_MOST["thesis"]


def test_keep_going_draws_the_strands_that_are_left(run: Runner) -> None:
    assert "warning: frame 4: strand" in run.fine("render", "bad.yaml", "-o", "a", "--keep-going").err
    data = report("a")
    assert (data["status"], len(data["frames"])) == ("complete", 6)
    assert data["warnings"][0].startswith("frame 4: strand")
    spoilt = data["frames"][3]
    assert spoilt["error"]["nonfinite"] > 0
    assert 0 < spoilt["counts"]["left_out"] < 150
    assert spoilt["counts"]["strands"] == 150 - spoilt["counts"]["left_out"]
    # the others drawn with all that is lost put out of the picture: pixel by pixel what is left
    scene = strandcli.load("bad.yaml")
    (frame,) = pipeline.render(scene, [5], draw=False, keep_positions=True, keep_going=True)
    good = np.isfinite(frame.positions).all((1, 2))
    assert good.sum() == data["frames"][4]["counts"]["strands"]
    bare = frame.positions.copy()
    bare[~good] = [0, -50, 0]  # far below the picture
    (other,) = pipeline.render(scene, [5], positions=lambda number: bare, keep_going=True)
    assert other.image is not None
    np.testing.assert_array_equal(png.read(Path("a", "frame_0005.png")), other.image)
    assert run("render", "bad.yaml", "-o", "b", "--keep-going", "-q").err == ""


def test_positions_kept_while_going_on_can_be_drawn_again(run: Runner) -> None:
    assert run("simulate", "bad.yaml", "-o", "p", "--keep-going").code == 0
    refused = run.refused("render", "bad.yaml", "-o", "a", "--from-cache", "p")
    assert "are not finite" in refused
    assert "--keep-going" in refused
    assert run("render", "bad.yaml", "-o", "b", "--from-cache", "p", "--keep-going").code == 0
    assert run("render", "bad.yaml", "-o", "c", "--keep-going").code == 0
    hashes = {name: [entry["pixels_sha256"] for entry in report(name)["frames"]] for name in "bc"}
    assert hashes["b"] == hashes["c"]


def test_panels_name_the_one_that_went_wrong(run: Runner) -> None:
    text = Path("bad.yaml").read_text() + "panels: [{label: calm, set: {rooted.after: 99}}, {label: wild}]\n"
    Path("panels.yaml").write_text(text)
    assert "wild: frame 4: strand" in run("render", "panels.yaml", "-o", "a").error()


def made(solver: str, residual: float, stretch: float = 1.0, away: float = 0.0) -> Solver:
    """A solver as `health.examine` sees one: 200 strands of two segments along x, the last of them stretched; what
    iterations left of strand 130 is given, and little of all others."""
    particles = np.zeros((200, 3, 3), np.float32)
    particles[:, :, 0] = np.float32(away) + np.arange(3, dtype=np.float32)
    particles[199, 2, 0] += np.float32(stretch - 1)
    scene = SimpleNamespace(solver=solver, label="", rod=SimpleNamespace(iterations=8), rules=())
    residuals = np.full(200, 0.1)
    residuals[130] = residual
    return SimpleNamespace(  # type: ignore[return-value]
        scene=scene, strands=200, particles=lambda: particles, rest_lengths=lambda: np.ones(200, np.float32),
        positions=np.zeros((2, 4, 384), np.float32), strand_residuals=lambda: residuals,
    )  # fmt: skip


def errors(**values: Any) -> dict[str, Any]:
    return {"stretch_max": 0.0, "penetration_max": None, "residual_max": None, "nonfinite": 0, **values}


def test_a_residual_beyond_its_bound_names_the_constraint_and_the_strand() -> None:
    bound = health.RESIDUAL_MOST
    assert health.examine(made("rod", bound), 7, errors(residual_max=bound)) is None
    for worst in (1.5 * bound, float("nan")):
        trouble = health.examine(made("rod", worst), 7, errors(residual_max=worst))
        assert trouble.message.startswith("frame 7: strand 130 is off by ")
        assert trouble.strand == 130
        assert "the constraint of constant lengths is violated" in trouble.message
        assert "rod.iterations" in trouble.message


def test_a_rods_stretch_is_judged_beyond_what_rounding_costs() -> None:
    assert health.examine(made("rod", 0.0, 1.009), 2, errors(stretch_max=0.009)) is None
    trouble = health.examine(made("rod", 0.0, 1.02), 2, errors(stretch_max=0.02))
    assert trouble.strand == 199
    assert "strand 199 is stretched by 2 %, more than 1 %" in trouble.message
    # a million segments from the origin single precision is no better than that
    far = made("rod", 0.0, 1.0625, away=1e6)
    assert health.examine(far, 2, errors(stretch_max=0.0625)) is None


def test_a_run_of_which_nothing_is_left_ends() -> None:
    scene = strandcli.load("minimal", settings={"emitter.strands": 3, "time.frames": 1})
    lost = np.full((3, scene.emitter.particles, 3), np.nan, np.float32)
    with pytest.raises(SimulationError, match="no strand is left"):
        list(pipeline.render(scene, [1], positions=lambda number: lost, keep_going=True))
