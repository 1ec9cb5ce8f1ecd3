"""Settings that presets had once, or that people look for: one line each, with its place and what to do instead."""

from __future__ import annotations

from pathlib import Path

import pytest

from scene_files import refused
from scene_kit import complaint
from strandcli.scene.absent import GONE, NEVER


@pytest.mark.parametrize("path", [*GONE, *NEVER])
def test_each_is_told_in_a_preset_and_where_it_is_set(
    path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    setting, _, value = path.partition(": ")
    group, key = setting.split(".")
    told = NEVER.get(path, "")
    if path in GONE:
        told = (f"'{value}' is " if value else "") + "gone after {}; {}".format(*GONE[path])
    column = 3 + (len(key) + 2 if value else 0)
    assert complaint(f"{group}:\n  {key}: {value or '{a: 1}'}\n") == f"p.yaml:2:{column}: {setting}: {told}"
    assert refused("seed: 1\n", f"{setting}={value or 1}") == f"--set {setting}={value or 1}: {told}"
    if not value:
        assert refused("seed: 1\n", f"{setting}.0.a=1") == f"--set {setting}.0.a=1: {told}"
