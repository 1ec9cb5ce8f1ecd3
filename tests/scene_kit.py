"""What the tests of scenes share: made-up rules, so that these tests know no real one, short ways to load, and presets
as files: a library of three, and a folder to write others into."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from strandcli.errors import UsageError
from strandcli.scene import Fault, Scene, SceneError, library, load, loads
from strandcli.scene.fields import Vector, boolean, choice, integer, items, names, number, vector


@dataclass(frozen=True, slots=True)
class Nothing:
    """No parameters."""


@dataclass(frozen=True, slots=True)
class Pull:
    """A constant pull."""

    acceleration: Vector = vector((0.0, -9.81, 0.0), unit="m/s^2", doc="acceleration")


@dataclass(frozen=True, slots=True)
class Gust:
    """One gust."""

    time: float = number(0.0, low=0, unit="s", doc="when")


@dataclass(frozen=True, slots=True)
class Breeze:
    """Moving air."""

    strength: float = number(1.0, low=0, high=100, unit="m/s", doc="speed")
    direction: Vector = vector((1.0, 0.0, 0.0), nonzero=True, unit="1", doc="where to")
    octaves: int = integer(3, low=1, high=8, doc="layers of noise")
    gusty: bool = boolean(False, doc="changes over time")
    profile: str = choice("flat", ("flat", "log"), doc="change with height")
    gusts: tuple[Gust, ...] = items(Gust, doc="extra gusts")


@dataclass(frozen=True, slots=True)
class Bump:
    """Solids that are in the way."""

    with_: tuple[str, ...] = names(doc="names of solids; none: all")
    segments: bool = boolean(False, doc="segments too")


@dataclass(frozen=True)
class FakeRule:
    """A `RuleType`."""

    name: str
    Parameters: type
    order: float
    doc: str = ""
    check: Any = field(default=None)


def names_exist(parameters: Bump, scene: Scene) -> Iterable[tuple[str, str]]:
    """The check of the made-up collision rule."""
    known = {solid.name for solid in scene.solids}
    for index, name in enumerate(parameters.with_):
        if name not in known:
            yield f"with.{index}", f"no solid has the name {name!r}"


RULES: dict[str, FakeRule] = {
    rule.name: rule
    for rule in (
        FakeRule("elasticity", Nothing, 50.0, "Keeps lengths."),
        FakeRule("gravity", Pull, 10.0, "Pulls down."),
        FakeRule("wind", Breeze, 20.0, "Blows."),
        FakeRule("collision", Bump, 40.0, "Stops.", names_exist),
    )
}


def scene(text: str) -> Scene:
    """The scene of a text that has to be valid."""
    return loads(text, rules=RULES, name="p.yaml")


def faults(text: str) -> tuple[Fault, ...]:
    """The faults of a text that has to have some."""
    with pytest.raises(SceneError) as caught:
        loads(text, rules=RULES, name="p.yaml")
    return caught.value.faults


def complaints(text: str) -> list[str]:
    """The lines that a person reads about a text that has faults."""
    return [str(fault) for fault in faults(text)]


def complaint(text: str) -> str:
    """The one line about a text with one fault."""
    lines = complaints(text)
    assert len(lines) == 1, lines
    return lines[0]


def error_of(run: Callable[[], object]) -> UsageError | None:
    """The error that a person would be shown, or None; anything else goes on upward."""
    try:
        run()
    except UsageError as error:
        return error
    return None


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
