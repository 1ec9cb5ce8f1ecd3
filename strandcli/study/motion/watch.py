"""Timing a solver's steps on a machine that does other things too."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")

OUTLIER, LONG = 50.0, 0.02
"""A step that takes so many times the median, and so many seconds, was interrupted."""


class Stopwatch:
    """Times every step of one solver, from now on."""

    def __init__(self, solver: Any) -> None:
        self.times: list[float] = []
        step = solver.step

        def timed(at: float, dt: float) -> None:
            began = time.perf_counter()
            step(at, dt)
            self.times.append(time.perf_counter() - began)

        solver.step = timed

    @property
    def seconds(self) -> float:
        """All steps together; one during which the machine was elsewhere counts as the median one."""
        return without_pauses(self.times)


def without_pauses(times: list[float]) -> float:
    """The sum of times in seconds, interrupted ones replaced by the median."""
    if not times:
        return 0.0
    values = np.array(times)
    usual = float(np.median(values))
    return float(np.where(values > max(OUTLIER * usual, LONG), usual, values).sum())


def least(run: Callable[[], tuple[T, float]], quick: float = 0.2, times: int = 3) -> tuple[T, float]:
    """What a run gives, with the least of its seconds: one that is quick is repeated, to be timed fairly."""
    found, seconds = run()
    while seconds < quick and times > 1:
        found, again = run()
        seconds = min(seconds, again)
        times -= 1
    return found, seconds
