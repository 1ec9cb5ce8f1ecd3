"""Studies: what a person can ask of one, an axis, which makes an `Experiment` of that, and how it is carried out:
reference first, then every setting; then what follows from the figures.

An axis of another kind is one more class of experiment, and one entry in `strandcli.study.axes`.
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
from .points import Parameters, Point, by_line, cheapest, described, orders, pareto

SOLVERS = ("thesis", "rod")
STRANDS = 256
"""Of a preset, where not said otherwise: enough that a step is more than its preparation."""
LADDER = (0.1, 0.05, 0.02, 0.01, 0.005, 0.001)
"""Errors for which a setting is recommended where none was asked for."""


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


@dataclass
class Study:
    """All figures of one subject."""

    axis: str
    name: str
    title: str
    metric: str
    unit: str
    reference: dict[str, Any]
    """What errors are measured against."""
    margins: Mapping[str, float]
    points: list[Point]
    absent: Sequence[Mapping[str, str]]
    orders: list[dict[str, Any]]
    recommended: list[dict[str, Any]]

    def as_dict(self) -> dict[str, Any]:
        """Plain data: the mapping that `study --json` prints."""
        plain = ("axis", "name", "title", "metric", "unit", "reference", "orders", "recommended")
        points = [
            {
                "parameters": dict(point.parameters), "dt": point.sizes.get("dt"), "seconds": point.seconds,
                "error": point.error, "pareto": point.pareto,
                **({"counts": dict(point.counts)} if point.counts else {}),
            }
            for point in self.points
        ]  # fmt: skip
        return {**{name: getattr(self, name) for name in plain}, "points": points, "not_represented": self.absent}


def run(
    axis: type[Experiment],
    request: Request,
    max_error: float | None = None,
    step: Callable[[str], None] = lambda text: None,
    begin: Callable[[int], None] = lambda runs: None,
) -> Study:
    """Measure all settings of a subject. ``begin`` gets how many runs there will be, ``step`` a line after each."""
    experiment = axis(request)
    settings = list(experiment.settings())
    begin(experiment.references + len(settings))
    reference = experiment.prepare(step)
    metric = experiment.metric
    points = []
    for parameters in settings:
        point = experiment.measure(parameters)
        points.append(point)
        error = point.error.get(metric)
        step(f"{described(parameters)}: {point.seconds:.3g} s, {metric} {'-' if error is None else f'{error:.3g}'}")
    front = pareto([point.seconds for point in points], [rounded(point.error.get(metric)) for point in points])
    for point, on_front in zip(points, front, strict=True):
        point.pareto = on_front
    margins = experiment.margins()
    names = dict.fromkeys([metric, *(name for point in points for name in point.error)])
    return Study(
        axis=axis.axis, name=request.name, title=experiment.title, metric=metric, unit=experiment.unit,
        reference=reference, margins=margins, points=points, absent=experiment.absent,
        orders=[one for name in names for one in orders(points, name)],
        recommended=recommendations(points, metric, margins, max_error),
    )  # fmt: skip


def recommendations(
    points: list[Point], metric: str, margins: Mapping[str, float], max_error: float | None
) -> list[dict[str, Any]]:
    """The cheapest setting of each solver under each error."""
    out: list[dict[str, Any]] = []
    for solver, mine in by_line(points, lambda point: point.solver).items():
        seen = None
        for most in LADDER if max_error is None else (max_error,):
            found = cheapest(mine, metric, most, margins)
            if found is None or (max_error is None and found is seen):
                continue
            seen = found
            out.append({
                "max_error": most, "parameters": dict(found.parameters), "seconds": found.seconds,
                "error": found.error[metric], "margin": margins.get(solver, 0.0),
            })  # fmt: skip
    return out


def rounded(error: float | None) -> float | None:
    """An error to three digits: what differs less counts as equally right, and the faster is the better."""
    return None if error is None else float(f"{error:.2e}")
