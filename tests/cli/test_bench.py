"""`strandcli bench PRESET`: its table and JSON, and what it refuses."""

from __future__ import annotations

import json

import pytest

from cli_runs import Runner


def test_a_presets_stages_stand_beside_what_they_work_on(run: Runner) -> None:
    data = json.loads(run("bench", "tiny.yaml", "--size", "64x48", "--frames", "2", "--threads", "1", "--json").out)
    assert (data["preset"], data["size"], data["frames"], data["threads"]) == ("tiny.yaml", [64, 48], 2, 1)
    stages = data["stages"]
    assert set(stages) >= {"simulate", "curves", "shadow", "raster", "shade", "film", "write"}
    assert stages["simulate"]["count"] == 150 * 5
    assert (stages["write"]["element"], stages["write"]["count"]) == ("byte", 3 * 64 * 48)
    assert stages["film"]["count"] == data["counts"]["samples"]
    assert stages["shade"]["count"] == data["counts"]["segments"] * data["counts"]["lights"]
    for row in stages.values():
        assert row["min_ms"] <= row["median_ms"]
        if row["element"] is not None:
            assert row["count"] > 0
            assert row["element_ns"] > 0
    assert data["frame"]["median_ms"] >= sum(row["min_ms"] for row in stages.values()) * 0.999
    assert (data["counts"]["strands"], data["clock"]) == (150, "wall")


def test_a_preset_has_as_many_strands_as_are_asked_for(run: Runner) -> None:
    few = ("--strands", "40", "--particles", "4", "--solver", "rod", "--size", "64x48", "--frames", "1")
    data = json.loads(run("bench", "tiny.yaml", *few, "--threads", "1", "--set", "seed=3", "--json").out)
    assert (data["counts"]["guides"], data["counts"]["particles_a_strand"]) == (40, 4)
    assert data["set"] == ["seed=3", "emitter.strands=40", "emitter.particles=4", "solver=rod"]


def test_the_table_has_a_row_a_stage(run: Runner) -> None:
    lines = run("bench", "tiny.yaml", "--size", "64x48", "--frames", "1", "--threads", "1", "--cpu").out.splitlines()
    assert lines[0] == "tiny.yaml, 64x48, 1 frame one by one, 1 thread, the processor's time of all"
    assert lines[2].split()[:3] == ["stage", "median", "ms"]
    simulate = next(line for line in lines[3:] if line.startswith("simulate"))
    assert "750 particle and step" in simulate
    assert len(simulate) == len(lines[2])
    assert any(line.startswith("write") and "9,216 byte" in line for line in lines)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["har"], "no preset 'har'; did you mean 'hair'?"),
        (["hair", "--strands", "9", "--set", "emitter.strands=10"], "--set emitter.strands: write --strands for it"),
        (["hair", "--growth"], "--growth: is of the headline scene, not of hair"),
        (["--cpu"], "--cpu: is of a preset; name one"),
        (["solvers"], "has 2 panels, and bench times a single picture"),
        (["tiny.yaml", "--frames", "12"], "has 12 frames, and the first is not counted: use --frames 11 or fewer"),
        (["tiny.yaml", "--set", "wind.strenght=1"], "strenght"),
    ],
)
def test_contradictions_and_what_is_not_there_are_refused_in_a_line(
    run: Runner, arguments: list[str], words: str
) -> None:
    assert words in run.refused("bench", *arguments)
