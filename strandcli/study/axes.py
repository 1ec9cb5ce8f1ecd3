"""What an axis of study is: what a person can ask of one, and what it makes of that, an `Experiment`.

`sweep.run` does the rest: it measures every setting, finds the front, fits orders and recommends. An axis of another
kind is one more class of experiment, and one entry in `sweep.AXES`.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import UsageError
from ..scene.fields import made, settings_of, with_value
from ..scene.model import Scene
from ..scene.specs import ChoiceSpec
from .points import Parameters, Point

SOLVERS = ("thesis", "rod")
STRANDS = 256
"""Of a preset, where not said otherwise: enough that a step is more than its preparation."""


@dataclass(frozen=True)
class Request:
    """What a person asked for. None: the usual ones."""

    scene: Scene | None = None
    """The preset; None where a reference is studied."""
    name: str = ""
    """Of the preset or the reference."""
    strands: int | None = None
    """Of a preset, at most: the first so many of its groom."""
    span: float | None = None
    """Seconds of a preset's film."""
    solvers: tuple[str, ...] | None = None
    steps: tuple[float, ...] | None = None
    """In seconds."""
    substeps: tuple[int, ...] | None = None
    iterations: tuple[int, ...] | None = None
    particles: tuple[int, ...] | None = None
    cells: tuple[float, ...] | None = None
    """Of the rule interaction, metres."""
    size: tuple[int, int] | None = None
    """Of a picture; None: small."""
    frame: int = 1
    """That pictures are drawn of."""
    fixed: frozenset[str] = frozenset()
    """Dotted paths that were set by hand: these are not turned."""

    @property
    def single(self) -> Scene:
        """The preset. Raises `UsageError` where it has several panels."""
        assert self.scene is not None
        if self.scene.panels:
            raise UsageError(f"{self.name}: a preset of several panels; study the preset of one panel")
        return self.scene


class Experiment(ABC):
    """A subject that can be measured at any setting of its parameters; a class of it is an axis, a kind of error with
    the settings that buy it off."""

    axis: str
    """By which a person asks for it."""
    draws = False
    """Whether it is of pictures; else it is about motion."""
    metric: str
    """The error that settings are chosen by."""
    unit: str
    """What it is a share of."""
    title: str
    absent: Sequence[Mapping[str, str]] = ()
    """Solvers that cannot be measured, and why: {"solver", "why"}."""
    references: int = 0
    """Runs that `prepare` takes."""

    @abstractmethod
    def __init__(self, request: Request) -> None:
        """Raises `UsageError` for what cannot be studied."""

    @abstractmethod
    def prepare(self, step: Callable[[str], None]) -> dict[str, Any]:
        """Make whatever errors are measured against, calling ``step`` after each run; what the report says of it."""

    def margins(self) -> Mapping[str, float]:
        """How well the reference is known, by solver, in the metric. Nothing where it is exact."""
        return {}

    @abstractmethod
    def settings(self) -> Sequence[Parameters]:
        """All that is to be measured."""

    @abstractmethod
    def measure(self, parameters: Parameters) -> Point:
        """One of them."""


def chosen_solvers(request: Request) -> list[str]:
    """The solvers asked for, in the usual order. Raises `UsageError` for one that there is not."""
    for name in request.solvers or ():
        if name not in SOLVERS:
            raise UsageError(f"no solver '{name}'; the solvers are {', '.join(SOLVERS)}")
    return [name for name in SOLVERS if request.solvers is None or name in request.solvers]


def changed(scene: Scene, settings: Parameters) -> Scene:
    """A scene with settings at dotted paths replaced, items of lists by their number. Values are not validated."""
    for path, value in settings.items():
        scene = with_value(scene, path, value)
    return scene


def knows(scene: Scene, path: str, value: Any = None) -> bool:
    """Whether a scene has a setting at a dotted path, and where that is one of a few words, ``value`` (not None)."""
    node: Any = scene
    spec = None
    for part in path.split("."):
        if isinstance(node, tuple):
            if not part.isdecimal() or int(part) >= len(node):
                return False
            node = node[int(part)]
            continue
        cls: Any = type(node)
        settings = settings_of(cls) if dataclasses.is_dataclass(node) else {}
        if part not in settings:
            return False
        spec = settings[part].spec
        inner = getattr(node, settings[part].attribute)
        node = made(node, part) if inner is None else inner
    return value is None or not isinstance(spec, ChoiceSpec) or value in spec.options
