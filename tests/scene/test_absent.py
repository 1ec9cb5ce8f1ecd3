"""Settings that presets had once, or that people look for: one line each, with its place and what to do instead."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from scene_kit import complaint, refused
from strandcli.scene.suggest import GONE, NEVER

BALL = "solids:\n- {kind: sphere, name: head}\n"


class Written(NamedTuple):
    """How a preset has such a setting."""

    text: str
    column: int
    path: str
    told: str


def written(path: str) -> Written:
    """``path``: of the tables."""
    setting, _, value = path.partition(": ")
    group, *inner, key = setting.split(".")
    told = NEVER.get(path, "")
    if path in GONE:
        told = (f"'{value}' is " if value else "") + "gone after {}; {}".format(*GONE[path])
    star, within = "*" in inner, [one for one in inner if one != "*"]
    begin = ("  - " if star else "  ") + (f"{within[0]}: {{" if within else "")
    end = "}" if within else ""
    column = 1 + len(begin) + (len(key) + 2 if value else 0)
    text = f"{group}:\n{begin}{key}: {value or '{a: 1}'}{end}\n"
    text += f"    kind: {'point' if group == 'lights' else 'sphere'}\n" if star else ""
    return Written(text, column, setting.replace("*", "0"), told)


@pytest.mark.parametrize("path", [*GONE, *NEVER])
def test_each_is_told_in_a_preset_and_where_it_is_set(
    path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    one, value = written(path), path.partition(": ")[2]
    assert complaint(one.text) == f"p.yaml:2:{one.column}: {one.path}: {one.told}"
    for where in {one.path, one.path.replace("solids.0.", "solids.head.")}:
        assert refused(BALL, f"{where}={value or 1}") == f"--set {where}={value or 1}: {one.told}"
        if not value:
            assert refused(BALL, f"{where}.0.a=1") == f"--set {where}.0.a=1: {one.told}"
