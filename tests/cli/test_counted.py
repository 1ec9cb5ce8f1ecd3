"""Numbers of things in what commands say."""

from __future__ import annotations

from pathlib import Path

import pytest

from cli_runs import TINY, Runner


def test_one_strand_and_its_frame_are_planned(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.yaml").write_text(TINY)
    curves = "curves={mode: fixed, level: 0}"
    told = Runner(tmp_path, capsys)("plan", "tiny.yaml", "--strands", 1, "--set", "time.frames=1", "--set", curves).out
    assert "  1 strand, 5 particles, " in told
    assert " for 1 frame\n" in told
    assert "each segment becomes 1 piece\n" in told
