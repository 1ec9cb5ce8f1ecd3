"""`render --sweep`: the product of values, folders with safe names, a table, a sheet, a page; resuming."""

from __future__ import annotations

import csv
import itertools
import json
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cli_runs import Runner
from strandcli.cli import sweep
from strandcli.cli.sweep import Axis, axis_of, points
from strandcli.errors import SimulationError
from strandcli.output import png
from strandcli.run import pipeline


def table(path: str) -> list[dict[str, str]]:
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_each_combination_has_a_folder_with_the_pixels_of_a_plain_run(run: Runner) -> None:
    done = run.fine(
        "render", "tiny.yaml", "-f", "1-2", "-o", "s", "--sweep", "wind.strength=1,4", "--sweep", "seed=1-2"
    )
    assert done.err.splitlines()[-1] == "s: 4 runs; sweep.csv, sweep.png, report.html"
    rows = table("s/sweep.csv")
    assert [(row["wind.strength"], row["seed"]) for row in rows] == list(itertools.product("14", "12"))
    assert [row["folder"] for row in rows] == [f"strength_{w}-seed_{s}" for w in "14" for s in "12"]
    for row in rows:
        assert run("render", "tiny.yaml", "-f", "1-2", "-o", "plain", "--overwrite", "-q", "--no-html",
                   "--set", f"wind.strength={row['wind.strength']}", "--seed", row["seed"]).code == 0  # fmt: skip
        picture = Path("plain/frame_0002.png")
        assert png.pixels_sha256(png.read(picture)) == row["pixels_sha256"]
        assert png.pixels_sha256(png.read(Path("s", row["folder"], "frame_0002.png"))) == row["pixels_sha256"]
        assert Path("s", row["folder"], "report.html").exists()
    assert len({row["pixels_sha256"] for row in rows}) == 4
    page = Path("s/report.html").read_text()
    assert re.findall(r'href="([^"]+)"', page) == [f"{row['folder']}/report.html" for row in rows]
    assert page.count("<img") == 4
    assert png.read(Path("s/sweep.png")).shape[1] > 4 * 64


def test_a_sweep_goes_on_where_it_was_ended(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = ["render", "tiny.yaml", "-f", "1-2", "-o", "s", "--sweep", "seed=1-3"]
    render, begun = pipeline.render, []

    def ends(*given: Any, **options: Any) -> Any:
        begun.append(1)
        for frame in render(*given, **options):
            if len(begun) == 2 and frame.number == 2:
                raise KeyboardInterrupt
            yield frame

    monkeypatch.setattr(pipeline, "render", ends)
    assert run(*sweep).code == 130
    assert [row["seed"] for row in table("s/sweep.csv")] == ["1"]
    assert Path("s/seed_2/frame_0001.png").exists()
    assert not Path("s/seed_3").exists()
    monkeypatch.setattr(pipeline, "render", render)
    before = {path: path.stat().st_mtime_ns for path in Path("s").rglob("frame_*.png")}
    assert run(*sweep).code == 2
    data = json.loads(run.fine(*sweep, "--resume", "--json").out)
    assert [one["status"] for one in data["points"]] == ["complete"] * 3
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert len(list(Path("s").rglob("frame_*.png"))) == 6


def test_a_point_that_goes_wrong_is_told_and_the_others_go_on(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    render = pipeline.render

    def wrong(scene: Any, *given: Any, **options: Any) -> Any:
        if scene.seed == 2:
            raise SimulationError("frame 1: strand 3 is lost")
        yield from render(scene, *given, **options)

    monkeypatch.setattr(pipeline, "render", wrong)
    done = run("render", "tiny.yaml", "-f", "1", "-o", "s", "--sweep", "seed=1-3")
    assert done.code == 1
    assert "seed_2: frame 1: strand 3 is lost" in done.err
    assert [row["status"] for row in table("s/sweep.csv")] == ["complete", "failed", "complete"]
    assert "1 went wrong" in Path("s/report.html").read_text()


@pytest.mark.parametrize(("arguments", "words"), [
    (["wind.strength"], "is not KEY=VALUES"), (["seed=3-1"], "runs backwards; write 1-3"), (["seed=1,,2"], "empty"),
    (["seed=1-99999999"], "more than 10,000 values"),
    (["seed=1-200", "wind.strength=1-200"], "40,000 combinations"), (["seed=1", "seed=2"], "is given twice"),
    (["wind.strenght=1"], "did you mean"), (["wind.strength=1,x"], "--sweep wind.strength=x: must be"),
])  # fmt: skip
def test_what_is_no_sweep_is_told_before_anything_is_drawn(run: Runner, arguments: list[str], words: str) -> None:
    options = itertools.chain.from_iterable(("--sweep", one) for one in arguments)
    assert words in run.refused("render", "tiny.yaml", "-f", "1", "-o", "s", *options)
    assert not Path("s").exists()


def test_commas_in_brackets_and_quotes_belong_to_a_value() -> None:
    axis = axis_of("camera.position=[0,0,2], [1,0,2],'a,b'")
    assert axis == Axis("camera.position", ("[0,0,2]", "[1,0,2]", "'a,b'"))
    assert axis_of("seed=1-7x3,1,9").values == ("1", "4", "7", "9")
    assert axis_of("time.preroll=1e-3").values == ("1e-3",)


keys = st.from_regex(r"[a-z_.\[\]0-9/]{1,20}", fullmatch=True)
values = st.lists(st.text(min_size=1, max_size=40).filter(str.strip), min_size=1, max_size=4, unique=True)


@given(st.dictionaries(keys, values, min_size=1, max_size=3))
def test_names_are_safe_and_differ_on_every_file_system(axes: dict[str, list[str]]) -> None:
    found = points([Axis(key, tuple(given)) for key, given in axes.items()])
    names = [point.name for point in found]
    assert len({name.casefold() for name in names}) == len(names)
    for name in names:
        assert re.fullmatch(r"[A-Za-z0-9_+][A-Za-z0-9_.+-]*", name), name
        assert len(name) <= sweep.LONGEST_NAME + 9
        assert not name.endswith(".")
    assert [point.overrides() for point in found] == [
        tuple(f"{key}={value}" for key, value in zip(axes, one, strict=True))
        for one in itertools.product(*axes.values())
    ]


@given(st.text(max_size=60))
def test_any_text_is_an_axis_or_told(text: str) -> None:
    try:
        axis = axis_of(text)
    except ValueError:
        return
    assert axis.values
    assert all(axis.values)
