"""`strandcli warmup`: afterwards nothing is left to compile; packs; profiles."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cli_runs import Runner
from strandcli.compiling import clock, runtime
from strandcli.compiling.stores import Pack
from strandcli.jit import function
from strandcli.run import pipeline
from strandcli.scene import Scene, list_presets


def test_after_warmup_a_run_compiles_nothing(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[tuple[str, tuple[int, ...], tuple[int, int]]] = []
    render = pipeline.render

    def spy(scene: Scene, frames: range, **options: Any) -> Iterator[pipeline.Frame]:
        drawn.append((Path(scene.source).name, tuple(frames), scene.image.size))
        return render(scene, frames, **options)

    monkeypatch.setattr(pipeline, "render", spy)
    data = json.loads(run.fine("warmup", "tiny.yaml", "--json").out)
    assert data["presets"] == ["tiny.yaml"]
    assert Path(data["cache"]).is_dir()
    assert drawn == [("tiny.yaml", frames, (64, 48)) for frames in ((1, 2), (1,))]
    assert data["kernels"]["film.develop"] >= 1
    before = runtime.compile_seconds()
    assert run("render", "tiny.yaml", "-f", "5").code == 0
    assert runtime.compile_seconds() == before
    assert run("warmup", "nonesuch").code == 2
    assert run("warmup", "tiny.yaml", "--pack", "p", "--profile").code == 2


def test_warmup_takes_what_changes_kernels_and_writes_a_pack(run: Runner) -> None:
    options = ("--aov", "depth,shadow", "--quality", "draft", "--set", "seed=3")
    packed = json.loads(run("warmup", "tiny.yaml", *options, "--pack", "packs/tiny.pack", "--json").out)["pack"]
    assert Path(packed["file"]).stat().st_size == packed["bytes"]
    assert packed["kernels"] == len(Pack(Path(packed["file"]))) > 10
    before = runtime.compile_seconds()
    assert run("render", "tiny.yaml", *options, "-f", "1-3").code == 0
    assert runtime.compile_seconds() == before


def test_a_profile_has_a_line_a_kernel_the_dearest_first(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    @function
    def plus(x):
        return x + 1

    def draw(scene: Scene, frames: range, **options: Any) -> list[pipeline.Frame]:
        plus(1), plus(1.5)
        return []

    monkeypatch.setattr(pipeline, "render", draw)
    (row,) = json.loads(run("warmup", "tiny.yaml", "--profile", "--json").out)["profile"]
    assert row["name"].endswith("test_warmup.plus")
    assert (row["compiled"], row["why"], row["functions"]) == (2, ["x: float64, not int64"], 2)
    assert min(row["typing"], row["lowering"], row["llvm"]) > 0
    assert row["seconds"] == pytest.approx(row["typing"] + row["lowering"] + row["llvm"])
    assert min(row["instructions"], row["bytes"]) > 0
    plus = function(plus.py_func)
    lines = run("warmup", "tiny.yaml", "--profile").out.splitlines()
    assert lines[1].endswith("test_warmup.plus; x: float64, not int64")
    assert lines[2].endswith("1 kernel")


def test_warmup_takes_all_shipped_presets_when_none_is_named(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[str] = []
    monkeypatch.setattr(pipeline, "render", lambda scene, frames, **options: drawn.append(scene.source) or [])
    assert run("warmup", "-q").err == ""
    shipped = [str(path) for _, path in list_presets()]
    assert drawn == [path for path in shipped for _ in range(2)]  # with all threads, and with one
    drawn.clear()
    assert run("warmup", "all", "-q").code == 0
    assert len(drawn) == 2 * len(shipped)


def test_costs_are_of_shipped_presets() -> None:
    """After changes `make kernel-costs` measures anew."""
    table = json.loads(clock.COSTS.read_text(encoding="utf-8"))
    assert {"hair", "headline", "minimal"} <= set(table["presets"]) <= {name for name, _ in list_presets()}
    minimal = Counter(table["presets"]["minimal"])
    assert clock.kernels_of(dict(list_presets())["minimal"].as_posix()) == minimal
    assert clock.seconds_of(minimal) > len(minimal) / 10
    assert not clock.kernels_of("/home/me/minimal.yaml")
    assert not clock.kernels_of("")  # of a scene that comes from no file
