"""Rules from outside the package that go wrong: one takes the root of a negative number, one grows without end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from strandcli.constants import W
from strandcli.scene.fields import number
from strandcli.simulate.rules import Moment, Pass


@dataclass(frozen=True, slots=True)
class Moments:
    """When it begins."""

    after: float = number(0.0, low=0, unit="s", doc="until then nothing happens")


def root_of_x(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """p[0]: x beyond which the root is of a negative number."""
    for k in range(W):
        x[k] += p[1] * math.sqrt(p[0] - x[k])


def grow(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """p[0]: the factor by which a particle goes away from its parent."""
    for k in range(3 * W):
        x[k] = parent[k] + p[0] * (x[k] - parent[k])


def _passes(function: Any, before: tuple[float, ...], after: tuple[float, ...]) -> Any:
    def passes(parameters: Moments, scene: Any) -> list[Pass]:
        def prepare(moment: Moment) -> Any:
            return np.array(after if moment.time > parameters.after else before, np.float32)

        return [Pass(function, prepare)]

    return passes


rooted = SimpleNamespace(
    name="rooted", order=25.0, Parameters=Moments, passes=_passes(root_of_x, (1e30, 0.0), (0.0, 0.0))
)
"""Makes every strand NaN that reaches beyond x = 0."""
growing = SimpleNamespace(name="growing", order=25.0, Parameters=Moments, passes=_passes(grow, (1.0,), (300.0,)))
"""Stretches every segment to 300 times its length."""
