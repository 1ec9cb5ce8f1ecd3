"""A study of solvers that are made up, whose errors are known."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from strandcli.study import sweep
from strandcli.study.points import Point, grid
from strandcli.study.sweep import Experiment, Request


class Synthetic(Experiment):
    """Two solvers of order 1 and 2 in the step, both of order 2 in the segments; the second costs four times more."""

    axis = "reference"
    metric, unit, title = "tip", "of the length", "a made-up solver"
    references = 2

    def __init__(self, request: Request) -> None:
        """The margin is what a request has as its span."""
        self.absent = [{"solver": "thesis", "why": "not represented: inertia"}]
        self.margin = request.span or 0.0

    def prepare(self, step: Callable[[str], None]) -> dict[str, Any]:
        step("one")
        step("two")
        return {"name": "synthetic", "exact": {"a": 1.0}}

    def margins(self) -> Mapping[str, float]:
        return {"one": self.margin, "two": self.margin}

    def settings(self) -> list[dict[str, Any]]:
        return grid({"solver": ("one", "two"), "emitter.particles": (5, 9, 17, 33), "dt": (0.04, 0.02, 0.01, 0.005)})

    def measure(self, parameters: Any) -> Point:
        n, dt = parameters["emitter.particles"], parameters["dt"]
        power = {"one": 1, "two": 2}[parameters["solver"]]
        error = 0.3 * (10 * dt) ** power + 0.3 / (n - 1) ** 2
        seconds = n / dt * (1e-4 if power == 1 else 4e-4)
        return Point(
            parameters, seconds, {"tip": error, "other": None}, parameters["solver"], {"dt": dt, "segment": 1 / (n - 1)}
        )


def made(max_error: float | None = None, margin: float = 0.0) -> sweep.Study:
    return sweep.run(Synthetic, Request(name="synthetic", span=margin), max_error)
