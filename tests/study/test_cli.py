"""`strandcli study` and `render --max-error`: exit codes, files, and what is said about bad input."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from cli_runs import Runner
from strandcli.study import advice, sweep

STILL = """\
title: strands that have nothing to do
time: {frames: 6, preroll: 0.5}
emitter: {strands: 60, particles: 5, length: 0.6, jitter: 20}
image: {size: [48, 32]}
rules:
  - elasticity: {}
"""
FALLING = STILL.replace("  - elasticity", "  - gravity: {}\n  - elasticity")


@pytest.fixture
def run(run: Runner) -> Runner:
    Path("still.yaml").write_text(STILL)
    Path("falling.yaml").write_text(FALLING)
    return run


QUICK = ("--solver", "thesis", "--substeps", "1,2", "--strands", "20", "--no-progress")


def test_a_preset_is_studied(run: Runner) -> None:
    done = run.fine("study", "still.yaml", *QUICK, "--max-error", "1%", "-o", "s")
    assert "limit of thesis: known to" in done.out
    assert "under 1 %: solver=thesis" in done.out
    assert sorted(os.listdir("s")) == ["still.csv", "still.json", "still.svg"]
    data = json.loads(Path("s/still.json").read_text())
    assert (data["axis"], data["name"], data["metric"]) == ("motion", "still", "median")
    assert data["reference"]["limits"]["thesis"]["converges"]
    assert "threads" in data["machine"]
    assert "--overwrite" in run.refused("study", "still.yaml", *QUICK, "-o", "s")


def test_no_file_is_replaced_unasked_and_nothing_measured_that_cannot_be_written(
    run: Runner, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweep, "run", lambda *arguments: pytest.fail("measured"))
    Path("s").mkdir()
    Path("s/still.svg").write_text("somebody's")
    refused = run("study", "still.yaml", *QUICK, "-o", "s")
    assert (refused.code, "still.svg: is there already; add --overwrite" in refused.error()) == (2, True)
    Path("file").touch()
    refused = run("study", "still.yaml", *QUICK, "-o", "file")
    assert (refused.code, "file: is a file, not a folder" in refused.error()) == (4, True)


def test_what_is_set_by_hand_is_not_turned(run: Runner) -> None:
    few = ("--solver", "thesis", "--strands", "20", "--no-progress", "--json", "-q")
    done = run.fine("study", "still.yaml", *few, "--set", "time.substeps=3", "--set", "emitter.particles=7")
    (point,) = json.loads(done.out)["points"]
    assert point["parameters"] == {"solver": "thesis", "emitter.particles": 7, "time.substeps": 3}


def test_no_setting_under_an_error_is_exit_code_3(run: Runner) -> None:
    done = run.refused("study", "falling.yaml", *QUICK, "--max-error", "0.01", "-q", code=3)
    assert "no setting keeps under an error of 1 %: falling: thesis comes to 6.8" in done
    assert done.endswith("try finer --substeps or --particles")
    assert Path("out/study/falling.svg").exists()


def test_what_is_said_of_a_study_that_found_nothing() -> None:
    from strandcli.study.points import Point
    from strandcli.study.report import why_missed
    from strandcli.study.sweep import Study

    limits = {"rod": {"converges": True, "uncertainty": 0.02}, "thesis": {"converges": False}}
    points = [
        Point({}, 1.0, {"median": error}, name) for name, error in (("thesis", 0.5), ("rod", 0.07), ("rod", 0.05))
    ]
    study = Study("motion", "hair", "", "median", "of the length", {"limits": limits}, {}, points, [], [], [])
    assert why_missed([study], 0.01) == (
        "no setting keeps under an error of 1 %: hair: thesis has no limit in sight, rod comes to 5 %, its limit known "
        "to 2 %; try finer --substeps or --particles"
    )


def test_a_reference_that_nobody_represents(run: Runner) -> None:
    done = run.fine("study", "--reference", "swing", "--solver", "thesis", "--json", "-q", "--max-error", "1%")
    data = json.loads(done.out)
    assert data["points"] == []
    assert data["not_represented"] == [{"solver": "thesis", "why": "not represented: inertia"}]
    assert data["reference"]["exact"]


def test_several_references(run: Runner) -> None:
    few = ("--solver", "rod", "--dt", "1/24", "--particles", "7", "--iterations", "8")
    done = run.fine("study", "--reference", "spring,swing", *few, "--json", "-q")
    names = [study["name"] for study in json.loads(done.out)["studies"]]
    assert names == ["spring", "swing"]
    assert {"spring.svg", "swing.csv"} <= set(os.listdir("out/study"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--reference", "elastika"], "did you mean 'elastica'"),
        (["--reference", "nothing"], "they are elastica"),
        (["--reference", ""], "empty name"),
        ([], "either a PRESET or --reference"),
        (["still.yaml", "--reference", "beam"], "either a PRESET or --reference"),
        (["no_such"], "no preset"),
        (["still.yaml", "--axis", "taste"], "axes are"),
        (["still.yaml", "--axis", ""], "no axis ''; the axes are"),
        (["still.yaml", "--axis", "reference"], "studies no preset"),
        (["still.yaml", "--solver", "springs"], "solvers are"),
        (["still.yaml", "--substeps", "0"], "from 1 to 1000"),
        (["still.yaml", "--substeps", "1,x"], "'x' is not a whole number"),
        (["still.yaml", "--particles", "1"], "from 2 to"),
        (["still.yaml", "--iterations", "1001"], "from 1 to 1000"),
        (["still.yaml", "--dt", "0"], "not a step"),
        (["still.yaml", "--dt", "1/0"], "not a step"),
        (["still.yaml", "--dt", "nan"], "not a step"),
        (["still.yaml", "--dt", "0.03"], "no whole part of a frame"),
        (["still.yaml", "--dt", "1/24", "--substeps", "2"], "exclude each other"),
        (["still.yaml", "--span", "0"], "0.001<=x<=3600"),
        (["still.yaml", "--strands", "0"], "range 1<=x"),
        (["still.yaml", "--cells", "0"], "'0' is not a length above 0"),
        (["still.yaml", "--cells", "nan"], "not a length above 0"),
        (["still.yaml", "--axis", "shadow", "--cells", "1"], "--cells does not go with axis shadow"),
        (["still.yaml", "--cells", "1"], "lists no rule interaction"),
        (["--reference", "beam", "--cells", "0.02"], "--cells is for presets"),
        (["still.yaml", "--set", "time.substeps"], "KEY=VALUE"),
        (["--reference", "beam", "--strands", "4"], "--strands is for presets"),
        (["--reference", "beam", "--set", "seed=1"], "--set is for presets"),
        (["still.yaml", "-q", "-v"], "exclude each other"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(run: Runner, arguments: list[str], words: str) -> None:
    assert words in run.refused("study", *arguments)
    assert not Path("out").exists()


@pytest.mark.parametrize("command", ["study", "render"])
@pytest.mark.parametrize(
    "given", ["0", "0%", "-1%", "-0.1", "nan", "inf", "NaN%", "101%", "1.5", "", "1 %%", "a few", "1e999"]
)
def test_errors_that_are_none(run: Runner, command: str, given: str) -> None:
    assert "--max-error" in run.refused(command, "still.yaml", f"--max-error={given}")


@pytest.mark.parametrize("given", ["1%", "0.01", "1e-2", " 1 % ", "1.0%", ".01"])
def test_errors_may_be_written_as_shares_or_percent(given: str) -> None:
    from strandcli.cli.values import error_share

    assert error_share(given) == pytest.approx(0.01)


def test_render_takes_the_cheapest_setting_and_remembers_it(
    run: Runner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(advice, "folder", lambda: tmp_path / "kept")
    first = run.fine("render", "still.yaml", "-f", "1", "-o", "a", "--max-error", "1%", "--no-progress")
    assert "by a study" in first.err
    assert "still: under 1 %: " in first.err
    assert "time.substeps=" in first.err
    second = run.fine(
        "render", "still.yaml", "-f", "1", "-o", "b", "--max-error", "2%", "--size", "30x20", "--no-progress"
    )
    assert "by an earlier study" in second.err
    assert len(list((tmp_path / "kept").iterdir())) == 1
    fixed = run.fine(
        "render", "still.yaml", "-f", "1", "-o", "c", "--max-error", "1%", "--particles", "7", "--no-progress"
    )
    assert "particles" not in fixed.err.splitlines()[0]
    assert json.loads(Path("c/report.json").read_text())["frames"][0]["counts"]["particles"] == 60 * 7


def test_render_refuses_an_error_that_no_setting_keeps(run: Runner) -> None:
    done = run.refused("render", "falling.yaml", "-f", "1", "--max-error", "1%", "--no-progress", code=3)
    assert "no setting of the solver thesis" in done
    assert not Path("out").exists()
    assert "exclude each other" in run.refused("render", "falling.yaml", "--max-error", "1%", "--from-cache", "x")
