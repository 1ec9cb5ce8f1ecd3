"""Presets as files: a library of three, a folder to write others into, and short ways to load them."""

from __future__ import annotations

from pathlib import Path

import pytest

from scene_kit import RULES
from strandcli.errors import UsageError
from strandcli.scene import Scene, library, load


def make_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a library of three presets, in use; the current folder is an empty one beside it."""
    presets = tmp_path / "presets"
    (presets / "figures").mkdir(parents=True)
    (presets / "hair.yaml").write_text("title: shipped hair\nseed: 7\n")
    (presets / "figures" / "fig02.yaml").write_text("title: figure 2\n")
    (presets / "figures" / "fig03.yaml").write_text("extends: figures/fig02\nseed: 3\n")
    monkeypatch.setattr(library, "folder", lambda: presets)
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    return presets


def write(name: str, text: str) -> str:
    """Write a preset into the current folder; its name."""
    path = Path(name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return name


def fails(name: str, *overrides: str, **settings: object) -> str:
    """The message with which a preset is refused."""
    with pytest.raises(UsageError) as caught:
        load(name, rules=RULES, overrides=overrides, settings=settings)
    assert caught.value.exit_code == 2
    return str(caught.value)


def changed(text: str, *overrides: str) -> Scene:
    """The scene of a preset's text, written to p.yaml."""
    return load(write("p.yaml", text), rules=RULES, overrides=overrides)


def refused(text: str, *overrides: str) -> str:
    """The message with which it is refused."""
    return fails(write("p.yaml", text), *overrides)
