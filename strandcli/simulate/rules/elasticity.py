"""Elasticity: every segment takes back its rest length (thesis §2).

p_i' = p_i + (p_i − p_{i−1}) (L − |p_i − p_{i−1}|) / |p_i − p_{i−1}|, root to tip: one sweep is exact. Coincident
particles have no direction and are not moved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .rule import Moment, Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

name = "elasticity"
order = 60.0
COINCIDENT, ZERO = 0, 1
"""Columns of p: a squared length below which two particles coincide; the number 0."""


@dataclass(frozen=True, slots=True)
class Parameters:
    """Segments are inextensible: there is nothing to set."""


def apply(a: Any, b: Any, c: Any, length: Any, p: Any) -> Any:
    """Return a particle's place at the rest length from the one before it; p: columns above."""
    dx = a[0] - b[0]
    dy = a[1] - b[1]
    dz = a[2] - b[2]
    size = math.sqrt(max(dx * dx + dy * dy + dz * dz, p[COINCIDENT]))
    # what flew off so far that its square overflows must not come back as a strand of no length: 0 * inf is NaN
    f = length / size + p[ZERO] * size
    return b[0] + dx * f, b[1] + dy * f, b[2] + dz * f


def passes(parameters: Parameters, scene: Scene) -> list[Pass]:
    """One pass."""

    def prepare(moment: Moment) -> Any:
        import numpy as np

        return np.array([1e-36, 0.0], np.float32)

    return [Pass(apply, prepare, "lane", 2)]
