"""Warnings are said once a run, whatever number of panels, frames or grooms they are of."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cli_runs import TINY, Runner
from strandcli.cli.progress import Progress, warner


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Runner:
    panels = "panels: [{label: one, set: {seed: 1}}, {label: two, set: {seed: 2}}]\n"
    text = TINY.replace("frames: 12", "frames: 12, loop: true")
    text = text.replace("length: 0.6", "length: 0.6, keys: [{time: 0}, {time: 0.4, position: [1, 0, 0]}]")
    (tmp_path / "two.yaml").write_text(text + "material: {width: 0.0003}\n" + panels)
    monkeypatch.chdir(tmp_path)
    return Runner(tmp_path, capsys)


def test_panels_share_their_warnings(run: Runner) -> None:
    loop, thin = run("plan", "two.yaml").err.splitlines()
    assert loop.startswith("warning: one, two: emitter: time.loop repeats")
    assert thin.startswith("warning: one, two: strands 0.3 mm wide")
    done = run("render", "two.yaml", "-f", "1-2", "-o", "a")
    *warnings, last = done.err.splitlines()
    assert last.startswith("a: 2 frames")
    assert warnings == [thin, loop.replace("one, two", "one")]
    kept = json.loads(Path("a/report.json").read_text())["warnings"]
    assert [f"warning: {words}" for words in kept] == warnings


def test_a_warning_is_said_once(capsys: pytest.CaptureFixture[str]) -> None:
    recorded: list[str] = []
    heard: set[str] = set()
    for _ in range(2):  # two grooms
        warn = warner(Progress(1, "", hidden=True), False, recorded.append, heard=heard)
        for words in ("a", "b", "a"):
            warn(words)
    assert capsys.readouterr().err == "warning: a\nwarning: b\n"
    assert recorded == ["a", "b"]
