"""Carrying out a study: reference first, then every setting; then what follows from the figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import UsageError
from .axes import Experiment, Request
from .motion import Motion
from .pictures.frame import CoverageStudy, QualityStudy
from .pictures.shadow import ShadowStudy
from .points import Point, by_line, cheapest, described, orders, pareto
from .references import References

AXES: Mapping[str, type[Experiment]] = {
    one.axis: one for one in (Motion, References, CoverageStudy, ShadowStudy, QualityStudy)
}

LADDER = (0.1, 0.05, 0.02, 0.01, 0.005, 0.001)
"""Errors for which a setting is recommended where none was asked for."""


def find(name: str) -> type[Experiment]:
    """An axis by name. Raises `UsageError`."""
    if name not in AXES:
        raise UsageError(f"no axis '{name}'; the axes are {', '.join(AXES)}")
    return AXES[name]


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
