"""What an axis of study is: its knobs, its reference and its metric; and what a person can ask of one.

An axis makes an `Experiment`, and `sweep.run` does the rest: it measures every setting, finds the front, fits orders
and recommends. An axis of another kind is one more file with an `Axis` in it, and one entry in `registry`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from ..errors import UsageError
from ..scene.model import Scene
from .points import Knobs, Point

Notify = Callable[[str], None]
SOLVERS = ("thesis", "rod", "foil")
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
    guides: tuple[int, ...] | None = None
    """Strands that are simulated, for all that are drawn."""
    size: tuple[int, int] | None = None
    """Of a picture; None: small."""
    frame: int = 1
    """That pictures are drawn of."""
    fixed: frozenset[str] = frozenset()
    """Dotted paths that were set by hand: axes of pictures do not turn them."""


def settled(scene: Scene, paths: Iterable[str]) -> dict[str, Any]:
    """What a request has to hold so that settings at dotted paths keep the scene's own values; other paths are no knobs
    of motion."""
    knobs: dict[str, tuple[str, Any]] = {
        "time.substeps": ("substeps", scene.time.substeps),
        "rod.iterations": ("iterations", scene.rod.iterations),
        "emitter.particles": ("particles", scene.emitter.particles),
    }
    return {name: (value,) for path, (name, value) in knobs.items() if path in set(paths)}


class Experiment(Protocol):
    """A subject that can be measured at any setting of its knobs."""

    metric: str
    """The error that settings are chosen by."""
    unit: str
    """What it is a share of."""
    title: str
    absent: list[dict[str, str]]
    """Solvers that cannot be measured, and why: {"solver", "why"}."""

    @property
    def references(self) -> int:
        """Runs that `prepare` takes."""
        ...

    def prepare(self, step: Callable[[str], None]) -> dict[str, Any]:
        """Make whatever errors are measured against, calling ``step`` after each run; what the report says of it."""
        ...

    def margins(self) -> Mapping[str, float]:
        """How well the reference is known, by solver, in the metric. Nothing where it is exact."""
        ...

    def settings(self) -> Sequence[Knobs]:
        """All that is to be measured."""
        ...

    def measure(self, knobs: Knobs) -> Point:
        """One of them."""
        ...


@dataclass(frozen=True)
class Axis:
    """A kind of error, and the knobs that buy it off."""

    name: str
    doc: str
    knobs: tuple[str, ...]
    metric: str
    of_preset: bool
    """Whether it studies a preset; else a reference by name."""
    open: Callable[[Request], Experiment]
    pictures: bool = False
    """Whether it draws; else it is about motion."""


def chosen_solvers(request: Request) -> list[str]:
    """The solvers asked for, in the usual order. Raises `UsageError` for one that there is not."""
    for name in request.solvers or ():
        if name not in SOLVERS:
            raise UsageError(f"no solver '{name}'; the solvers are {', '.join(SOLVERS)}")
    return [name for name in SOLVERS if request.solvers is None or name in request.solvers]
