"""Settings that presets had once: one line each, with its place, and what to do instead."""

from __future__ import annotations

from pathlib import Path

import pytest

from scene_files import refused
from scene_kit import complaint
from strandcli.scene.gone import GONE


@pytest.mark.parametrize("path", GONE)
def test_each_is_told_in_a_preset_and_where_it_is_set(
    path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    last, instead = GONE[path]
    setting, _, value = path.partition(": ")
    group, key = setting.split(".")
    told = (f"'{value}' is " if value else "") + f"gone after {last}; {instead}"
    column = 3 + (len(key) + 2 if value else 0)
    assert complaint(f"{group}:\n  {key}: {value or '{a: 1}'}\n") == f"p.yaml:2:{column}: {setting}: {told}"
    assert refused("seed: 1\n", f"{setting}={value or 1}") == f"--set {setting}={value or 1}: {told}"
    if not value:
        assert refused("seed: 1\n", f"{setting}.0.a=1") == f"--set {setting}.0.a=1: {told}"
