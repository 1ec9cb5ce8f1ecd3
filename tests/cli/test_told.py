"""What is told of a run as a whole: warnings once, whatever they are of, and bytes on disk before and after."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cli_runs import TINY, Runner
from strandcli.cli.progress import Progress, warner
from strandcli.output.files import megabytes


def test_panels_share_their_warnings(run: Runner) -> None:
    panels = "panels: [{label: one, set: {seed: 1}}, {label: two, set: {seed: 2}}]\n"
    text = TINY.replace("frames: 12", "frames: 12, loop: true")
    text = text.replace("length: 0.6", "length: 0.6, keys: [{time: 0}, {time: 0.4, position: [1, 0, 0]}]")
    Path("two.yaml").write_text(text + "material: {width: 0.0003}\n" + panels)
    loop, thin = run("plan", "two.yaml").err.splitlines()
    assert loop.startswith("warning: one, two: emitter: time.loop repeats")
    assert thin.startswith("warning: one, two: strands 0.3 mm wide")
    *warnings, last = run("render", "two.yaml", "-f", "1-2", "-o", "a").err.splitlines()
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


def test_sizes_of_what_is_written_are_told_before_and_after(run: Runner) -> None:
    aovs = ["--set", "image.aovs=[depth, tangent]"]
    told = json.loads(run("plan", "tiny.yaml", "-f", "1-2", *aovs, "--json").out)
    assert told["frame_bytes"] == round((1.5 + 6 * 4) * 64 * 48)
    plain = run("plan", "tiny.yaml", "-f", "1-2", *aovs)
    assert "  at most about 78 kB of files a frame, 157 kB for 2 frames\n" in plain.out
    done = run("render", "tiny.yaml", "-f", "1-2", "-o", "a", "--animate", "gif", *aovs)
    files = [path for path in Path("a").iterdir() if not path.name.startswith("report.")]
    assert len(files) == 2 + 2 * 2 * 2 + 1
    assert done.error().endswith(f"; {megabytes(sum(path.stat().st_size for path in files))}")
    frames = [path for path in files if path.suffix != ".gif"]
    assert sum(path.stat().st_size for path in frames) <= 2 * told["frame_bytes"]
    again = run("render", "tiny.yaml", "-f", "1-2", "-o", "a", "--resume", *aovs)
    assert again.error().endswith(f"; 2 kept; {megabytes(sum(path.stat().st_size for path in frames))}")
