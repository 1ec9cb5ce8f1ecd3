"""docs/tour.md, followed line by line in an empty folder, small."""

from __future__ import annotations

import shlex
from pathlib import Path

from cli_runs import Runner
from pages import ROOT, blocks

SMALL = ["--size", "48x36", "--strands", "40", "--set", "children.count=3", "--set", "material.width=0.004",
         "--set", "time.preroll=0.1"]  # fmt: skip
CODES = {"compare": 3}
MADE = ("my.yaml", "out/first/report.html", "out/sweep/sweep.png", "out/film/animation.gif", "out/job/submit.sh")


def test_the_tour_can_be_followed(run: Runner) -> None:
    lines = [line for block in blocks(ROOT / "docs/tour.md") for line in block.text.splitlines() if line.strip()]
    assert len(lines) >= 10
    for line in lines:
        program, command, *words = shlex.split(line)
        assert program == "strandcli"
        small = SMALL if command in ("render", "simulate", "farm") else []
        done = run(command, *words, *small)
        assert done.code == CODES.get(command, 0), (line, done.err)
    assert [name for name in MADE if not Path(name).exists()] == []
