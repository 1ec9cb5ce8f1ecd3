"""Files that are written while a run goes on: told once, when it ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cli_runs import TINY, Runner
from strandcli.exchange.files import write
from strandcli.exchange.strands import Strands
from strandcli.output.report import read_report
from strandcli.run import pipeline

WORDS = "written after it had been read"
SMALL = ("--size", "16x16", "--quality", "draft", "-q", "--no-html")


@pytest.fixture
def run(run: Runner) -> Runner:
    hair("a.hair")
    return run


def hair(name: str, shift: float = 0.0) -> None:
    points = np.array([[k / 9 + shift, y / 9, 0] for k in range(4) for y in range(3)], np.float32)
    write(Path(name), Strands(np.arange(0, 13, 3), points))


def meanwhile(monkeypatch: pytest.MonkeyPatch, act: Callable[[], object]) -> None:
    """Do something after each frame of a run."""
    drawn = pipeline.render

    def render(*given: Any, **more: Any) -> Iterator[Any]:
        for frame in drawn(*given, **more):
            act()
            yield frame

    monkeypatch.setattr(pipeline, "render", render)


def warnings(folder: str) -> list[str]:
    data = read_report(Path(folder))
    assert data["status"] == "complete"
    return [one for one in data.get("warnings", []) if WORDS in one]


def test_an_input_that_changes_is_told_in_one_line(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    meanwhile(monkeypatch, lambda: hair("a.hair", shift=0.1))
    found = run.fine("render", "a.hair", "-o", "out", *SMALL[:4], "--no-html")
    assert warnings("out") == [f"{run.folder}/a.hair: {WORDS}, so results may be of either; run again to have the new"]
    assert found.err.count(f"warning: {run.folder}/a.hair: {WORDS}") == 1


def test_a_preset_that_changes_is_told_by_render_and_simulate(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    edits = iter(range(1, 99))
    meanwhile(monkeypatch, lambda: Path("tiny.yaml").write_text(f"{TINY}seed: {next(edits)}\n", encoding="utf-8"))
    run("render", "tiny.yaml", "-f", "1-2", "-o", "out", *SMALL)
    assert len(warnings("out")) == 1
    assert run("simulate", "tiny.yaml", "-f", "1-2", "-o", "p").err.count(WORDS) == 1


def test_what_is_touched_or_written_by_the_run_itself_is_not_told(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    run("render", "a.hair", "-o", "out", "--aov", "depth", *SMALL)
    Path("out/depth_0001.npz").write_bytes(b"torn")
    meanwhile(monkeypatch, Path("a.hair").touch)
    assert run("render", "a.hair", "-o", "out", "--aov", "depth", "--resume", *SMALL).code == 0
    assert Path("out/depth_0001.npz").stat().st_size > 99
    assert warnings("out") == []
    run("simulate", "tiny.yaml", "-f", "1-2", "-o", "p", "-q")
    Path("p/positions_0002.npz").write_bytes(b"torn")
    again = run("simulate", "tiny.yaml", "-f", "1-2", "-o", "p", "--resume")
    assert (again.code, WORDS in again.err) == (0, False)
