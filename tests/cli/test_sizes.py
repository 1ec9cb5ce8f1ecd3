"""Bytes on disk: told by `plan` before, and by `render` after."""

from __future__ import annotations

import json
from pathlib import Path

from cli_runs import Runner
from strandcli.output.files import megabytes


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
