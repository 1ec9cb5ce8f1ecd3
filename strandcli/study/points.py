"""What a sweep measured, and what follows from it: the Pareto front, orders of convergence, the cheapest setting.

Pure functions of numbers: no solver, no clock, no file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Parameters = Mapping[str, Any]
CELL = "rules.interaction.cell"


@dataclass
class Point:
    """One setting, measured."""

    parameters: Parameters
    """Settings by the path that `--set` takes; ``dt`` where it is not made of the rest."""
    seconds: float
    error: dict[str, float | None]
    """By metric, as shares; None where the run does not hold the quantity."""
    solver: str = ""
    sizes: dict[str, float] = field(default_factory=dict)
    """What is refined, by name: ``dt`` in seconds, ``segment`` as a share of the length. Smaller is finer."""
    pareto: bool = False
    series: str = ""
    """What else than a solver makes points one line of the chart."""
    counts: Mapping[str, int] = field(default_factory=dict)
    """Segments, fragments, bytes: what does not depend on the machine."""

    @property
    def line(self) -> str:
        """What points that lie on one line of the chart have in common."""
        return self.series or self.solver


def pareto(costs: Sequence[float], errors: Sequence[float | None]) -> list[bool]:
    """Which points no other beats: none is as cheap and as right, and better in one of both. A point without an error
    is never one of them."""
    known = [i for i, error in enumerate(errors) if error is not None and math.isfinite(error)]
    front = [False] * len(costs)
    best = math.inf
    last: tuple[float, float] | None = None
    for i in sorted(known, key=lambda i: (costs[i], errors[i])):
        pair = (costs[i], float(errors[i] or 0.0))
        if pair[1] < best or pair == last:
            front[i] = True
            best, last = pair[1], pair
    return front


def cheapest(
    points: Sequence[Point], metric: str, most: float, margins: Mapping[str, float] | None = None
) -> Point | None:
    """The point of least cost whose error, with its solver's margin added, is at most ``most``."""
    fit = []
    for point in points:
        error = point.error.get(metric)
        if error is not None and error + (margins or {}).get(point.solver, 0.0) <= most:
            fit.append(point)
    return min(fit, key=lambda point: point.seconds, default=None)


def fitted_order(sizes: Sequence[float], errors: Sequence[float]) -> float | None:
    """The order p of error = c + a size ** p, c ≥ 0 being what another cause leaves.

    From four sizes on all three are fitted, by least squares of relative errors; two or three give the slope through
    their logarithms. The finest are left out where errors rise again below a tenth of the greatest: that is rounding.
    None for fewer than two, and where the error does not fall with the size all the way, or by less than a sixth.
    """
    pairs = sorted({size: error for size, error in zip(sizes, errors, strict=True) if error > 0}.items())
    while len(pairs) > 3 and pairs[1][1] < 0.95 * pairs[0][1] < 0.095 * pairs[-1][1]:
        del pairs[0]
    found = [error for _, error in pairs]
    if len(pairs) < 2 or any(b < 0.95 * a for a, b in pairwise(found)) or found[-1] < 1.2 * found[0]:
        return None
    h, e = np.array([size for size, _ in pairs]), np.array(found)
    if len(pairs) < 4:
        return float(np.polyfit(np.log(h), np.log(e), 1)[0])
    tries = [(_misfit(h / h[-1], e, power), power) for power in np.linspace(0.1, 6, 1181)]
    return float(min(tries)[1])


def _misfit(h: NDArray[np.float64], e: NDArray[np.float64], power: float) -> float:
    """Sum of squared relative errors of the best c + a h ** power with c ≥ 0."""
    columns = np.stack([1 / e, h**power / e], 1)
    c, a = np.linalg.lstsq(columns, np.ones(len(e)), rcond=None)[0]
    if c < 0:
        c, a = 0.0, columns[:, 1].sum() / (columns[:, 1] ** 2).sum()
    return float(((columns @ np.array([c, a]) - 1) ** 2).sum())


def orders(points: Sequence[Point], metric: str) -> list[dict[str, Any]]:
    """The fitted order of a metric in each thing that is refined, for each line: along the points that differ from the
    line's best one in nothing else. ``order`` is None where there is none to be seen."""
    found: list[dict[str, Any]] = []
    for line in dict.fromkeys(point.line for point in points):
        mine = [point for point in points if point.line == line and point.error.get(metric) is not None]
        if not mine:
            continue
        best = min(mine, key=lambda point: point.error[metric] or 0.0)
        for name in best.sizes:
            series = [point for point in mine if _apart(point, best) <= {name}]
            if len({point.sizes[name] for point in series}) < 2:
                continue
            order = fitted_order(
                [point.sizes[name] for point in series], [point.error[metric] or 0.0 for point in series]
            )
            found.append({"line": line, "metric": metric, "in": name, "order": order, "points": len(series)})
    return found


SHAPED_BY: Mapping[str, tuple[str, ...]] = {
    "dt": ("dt", "time.substeps"), "segment": ("emitter.particles",), "cell": (CELL,),
}  # fmt: skip
"""Parameters behind each thing that is refined."""


def _apart(a: Point, b: Point) -> set[str]:
    """In what two points differ: names of sizes, and of parameters that are behind none."""
    behind = {parameter: name for name, parameters in SHAPED_BY.items() for parameter in parameters}
    return {
        behind.get(parameter, parameter)
        for parameter in {**a.parameters, **b.parameters}
        if a.parameters.get(parameter) != b.parameters.get(parameter)
    }


def grid(choices: Mapping[str, Sequence[Hashable]]) -> list[dict[str, Any]]:
    """Every combination, the last parameter changing fastest."""
    out: list[dict[str, Any]] = [{}]
    for name, values in choices.items():
        out = [{**one, name: value} for one in out for value in values]
    return out


def described(parameters: Parameters) -> str:
    """A setting in a few words, such as "rod, 16 particles, 8 substeps"."""
    words = [str(parameters["solver"])] if "solver" in parameters else []
    for path, value in parameters.items():
        name = path.rpartition(".")[2]
        if path == "dt":
            words.append(f"steps of {value:.3g} s")
        elif path in COUNTED:
            words.append(f"{value} {name}")
        elif path != "solver":
            words.append(f"{name} {value}")
    return ", ".join(words)


COUNTED = ("emitter.particles", "rod.iterations", "time.substeps")
"""Parameters that are numbers of what their name says."""


@dataclass(frozen=True)
class Limit:
    """How well the limit of a series of runs, each twice as fine as the one before, is known."""

    uncertainty: float
    """Bound on the distance of the finest run from the limit."""
    order: float | None
    """As seen in the three finest runs; None where they do not differ."""
    converges: bool
    """Whether the runs draw together at all."""


def limit(coarse: float, fine: float, noise: float = 0.0) -> Limit:
    """From the distances between the third finest run and the second, and between that one and the finest, each twice
    as fine as the one before: Richardson's extrapolation with the order that they show, clamped between 1/2 and 2, and
    Roache's safety factor 1.25 (1994). Below ``noise`` distances are nothing but rounding."""
    if fine <= noise:
        return Limit(fine, None, True)
    order = math.log2(coarse / fine) if coarse > 0 else -math.inf
    clamped = min(max(order, 0.5), 2.0)
    return Limit(1.25 * fine / (2**clamped - 1), order if math.isfinite(order) else None, order >= 0.5)


def by_line(points: Sequence[Point], key: Callable[[Point], str] = lambda point: point.line) -> dict[str, list[Point]]:
    """Points in groups, in the order in which they come."""
    out: dict[str, list[Point]] = {}
    for point in points:
        out.setdefault(key(point), []).append(point)
    return out
