"""The commands beside render: compare, sheet, golden, presets, schema, bench, claims."""

from __future__ import annotations

import json
import math
import re
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import strandcli
from cli_runs import TINY, Runner
from strandcli import study
from strandcli.output.compare import write_image
from strandcli.study import bench


def picture(path: str, change: int = 0) -> None:
    image = np.random.default_rng(1).integers(0, 200, (20, 30, 3), dtype=np.uint8)
    image[4, 5, 1] += change
    write_image(Path(path), image)


def test_presets_are_listed_shown_and_copied(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    home = run.folder / "home"
    (home / "figures").mkdir(parents=True)
    (home / "hair.yaml").write_text(TINY)
    (home / "figures" / "fig02.yaml").write_text("title: figure 2\n")
    monkeypatch.setattr("strandcli.scene.library.folder", lambda: home)
    listed = run("presets", "list").out
    assert [line.split()[0] for line in listed.splitlines()] == ["hair", "figures/fig02"]
    assert run("presets").out == listed
    assert json.loads(run("presets", "list", "--json").out)[1] == {"name": "figures/fig02", "title": "figure 2"}
    assert run("presets", "show", "hair").out == TINY
    assert run("presets", "copy", "figures/fig02").code == 0
    assert Path("fig02.yaml").read_text() == "title: figure 2\n"
    assert run("presets", "copy", "figures/fig02").code == 2
    assert run("presets", "copy", "hair", "fig02.yaml", "--overwrite").code == 0
    assert Path("fig02.yaml").read_text() == TINY
    assert run("presets", "copy", "hair", "no/such/a.yaml").code == 2
    assert "did you mean 'hair'" in run("presets", "show", "hai").error()


def test_a_copy_of_a_preset_draws_with_the_meshes_that_it_names(run: Runner) -> None:
    assert run("presets", "copy", "hair", "mine.yaml", "-q").code == 0
    assert Path("meshes/head.ply").exists()
    assert strandcli.load("mine.yaml").title == strandcli.load("hair").title
    assert run("presets", "copy", "hair", "again.yaml", "-q").code == 0, "the same mesh is there already"
    Path("meshes/head.ply").write_text("mine")
    assert "meshes/head.ply: is there already" in run.refused("presets", "copy", "hair", "other.yaml")
    assert not Path("other.yaml").exists()


@pytest.mark.parametrize("options", [(), ("--markdown",)])
def test_the_schema_and_the_reference_are_printed_or_written_where_asked(run: Runner, options: tuple[str, ...]) -> None:
    printed = run("schema", *options).out
    if options:
        assert printed.startswith("# Reference of presets\n")
    else:
        assert json.loads(printed)["$schema"].startswith("https://json-schema.org/")
    run.fine("schema", *options, "-o", "s")
    assert Path("s").read_text() == printed
    run.refused("schema", *options, "-o", "s")


def test_the_plan_is_printed_and_given_as_data(run: Runner) -> None:
    words = run("plan", "tiny.yaml").out
    assert "Runs:\n" in words
    assert "Left out:\n" in words
    assert "rule collision" in words.split("Left out:")[1]
    data = json.loads(run("plan", "tiny.yaml", "-f", "1-3", "--strands", "99", "--json").out)
    assert (data["strands"], data["frames"]) == (99, 3)
    assert {one["stage"] for one in data["used"]} >= {"rule wind", "rule gravity"}
    assert data["memory_bytes"] > 0
    assert not Path("out").exists()


def test_a_plan_refuses_an_environment_that_cannot_be_drawn(run: Runner) -> None:
    """As rendering does, in the same words; of panels, that of each."""
    Path("notes.png").write_text("no picture")
    told = run("render", "tiny.yaml", "--set", "environment.image=notes.png").error()
    planned = run("plan", "tiny.yaml", "--set", "environment.image=notes.png")
    assert planned.error() == told
    assert (planned.code, planned.out) == (2, "")
    Path("panels.yaml").write_text(TINY + "panels: [{label: a}, {label: b, set: {environment.image: notes.png}}]\n")
    assert run("plan", "panels.yaml").error() == told
    picture("sky.png")
    assert run("plan", "tiny.yaml", "--set", "environment.image=sky.png").code == 0
    assert "there is no file gone.png" in run("plan", "tiny.yaml", "--set", "environment.image=gone.png").error()


BENCH = {
    "strands": 10_000,
    "particles": 10,
    "size": [800, 600],
    "frames": 20,
    "threads": 2,
    "compile_seconds": 1.25,
    "stages": {
        "simulate": {"median_ms": 1.5, "min_ms": 1.25, "max_ms": 2},
        "write": {"median_ms": None, "min_ms": None, "max_ms": None},
    },
    "frame": {"median_ms": 20.0, "fps": 50.0},
    "counts": {"segments": 360_000},
    "particle_step_ns": 1.25,
    "steps": {"ms": 1.5, "particle_step_ns": 15.0},
    "rules": {"ms": 0.15, "particle_step_ns": 1.5},
    "lines": {"ms": 12.0, "fragment_ns": 6.5},
    "error": {"stretch_max": 0.001, "penetration_max": None},
    "frames_at_once": 1,
    "busy": {"others": 0.25, "stolen": 0.0},
}


def test_bench_passes_its_options_on_and_prints_a_table_or_json(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[object, ...]] = []

    def fake(*given: object) -> dict[str, object]:
        asked.append(given[:-1])
        return BENCH

    module = SimpleNamespace(run=fake, busy_words=bench.busy_words)
    monkeypatch.setitem(sys.modules, "strandcli.study.bench", module)
    monkeypatch.setattr(study, "bench", module, raising=False)
    result = run("bench", "--strands", "500", "--size", "80x60", "--frames", "3", "--threads", "1", "--json")
    assert json.loads(result.out) == BENCH
    own = {"emitter.strands": 500, "emitter.particles": 10, "solver": "thesis"}
    assert asked == [(own, 3, (80, 60), 1, ())]
    run("bench", "--set", "image.resolver=sorted", "--set", "material.width=0.0014")
    assert asked[1][4] == ("image.resolver=sorted", "material.width=0.0014")
    done = run("bench")
    assert "warning: the machine was busy: other programs took 25 % of its processors' time" in done.error()
    table = done.out
    assert "simulate          1.50      1.25" in table
    assert "frames a second               50.0" in table
    assert "steps alone                1.50 ms   15.00 ns a particle and step" in table
    assert "lines alone               12.00 ms   6.50 ns a fragment" in table
    assert "penetration_max" not in table
    refused = run("bench", "--set", "emitter.strands=5")
    assert (refused.code, "write --strands" in refused.error()) == (2, True)
    assert run("bench", "--strands", "0").code == 2
    assert run("bench", "--frames", "0").code == 2


def test_bench_tells_how_the_cost_of_a_particle_grows(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = {"strands": ((20, 4), (40, 4)), "particles": ((20, 4), (10, 16), (10, 32))}
    monkeypatch.setattr(bench, "GROWTH", sizes)
    data = json.loads(run("bench", "--growth", "--json").out)
    rows = data["growth"]
    assert [(row["strands"], row["particles"]) for row in rows] == [*sizes["strands"], *sizes["particles"]]
    for row in rows:
        assert row["particle_step_ns"] == pytest.approx(row["ms"] * 1e6 / (row["strands"] * row["particles"]))
    grown = [rows[1]["ms"] / rows[0]["ms"], rows[4]["ms"] / rows[3]["ms"]]  # in both, by twice
    assert list(data["exponents"].values()) == pytest.approx([math.log2(times) for times in grown])
    assert run("bench", "--growth", "--set", "wind.strenght=1").code == 2
    table = run("bench", "--growth").out.splitlines()
    assert table[0].startswith("thesis, ")
    assert table[3].split()[:2] == ["20", "4"]
    assert re.fullmatch(r"cost grows as strands \*\* \S+ and as particles \*\* \S+; \*\* 1 is linear", table[-1])


def test_claims_are_a_table_or_json(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [{"claim": "smoothing costs 30-50 % of a frame " * 3, "source": "30-50 %", "ours": "12 %"}]
    module = SimpleNamespace(run=lambda **options: {"claims": rows, "busy": None})
    monkeypatch.setitem(sys.modules, "strandcli.study.claims", module)
    monkeypatch.setattr(study, "claims", module, raising=False)
    assert json.loads(run("claims", "--json").out) == {"claims": rows, "busy": None}
    lines = run("claims").out.splitlines()
    assert lines[1].split("  ")[0].startswith("smoothing costs")
    assert "30-50 %" in lines[1]
    assert "12 %" in lines[1]
    assert len(lines) > 2


HOSTILE = "a\\u009b31m\\u202eb"


def test_nothing_of_a_preset_or_a_name_reaches_the_terminal_as_a_control(run: Runner) -> None:
    Path("odd\x1b[31m\u202e.yaml").write_text(f'panels: [{{label: "{HOSTILE}"}}]\ntitle: "{HOSTILE}"\n')
    for result in (run("plan", "odd\x1b[31m\u202e.yaml"), run("plan", "odd\x1b[31m\u202e.yaml", "--json"),
                   run("plan", "no\x1b[31m\u202e.yaml"), run("compare", "no\x9b.png", "no\u2066.png")):  # fmt: skip
        assert all(line.isprintable() for line in (result.out + result.err).splitlines())
    data = json.loads(run("plan", "odd\x1b[31m\u202e.yaml", "--json").out)
    assert data["used"][0]["stage"].startswith("a\x9b31m\u202eb")


def test_thin_strands_as_lines_of_a_pixel_are_warned_of(run: Runner) -> None:
    Path("thin.yaml").write_text(TINY + "material: {width: 0.0003}\n")
    told = run.fine("plan", "thin.yaml")
    assert told.error().startswith("warning: strands 0.3 mm wide are 0.004 pixels wide here")
    assert json.loads(run("plan", "thin.yaml", "--json").out)["warnings"] == [told.error().removeprefix("warning: ")]
    for fine in (["--quality", "default"], ["--set", "look=source"], ["--set", "material.width=0.3"],
                 ["--set", "image.resolver=sorted"], ["--set", "material.width=0"]):  # fmt: skip
        assert run("plan", "thin.yaml", *fine).err == ""
