"""Elasticity: every segment takes back its rest length (thesis §2).

p_i' = p_i + (p_i − p_{i−1}) (L − |p_i − p_{i−1}|) / |p_i − p_{i−1}|, root to tip: one sweep is exact. Coincident
particles have no direction and are not moved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ...constants import W
from .rule import Moment, Pass

name = "elasticity"
order = 60.0


@dataclass(frozen=True, slots=True)
class Parameters:
    """Segments are inextensible: there is nothing to set."""


def apply(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """p[0]: a squared length below which two particles coincide; p[1]: zero."""
    tiny = p[0]
    zero = p[1]
    for k in range(W):
        qx = parent[k]
        qy = parent[W + k]
        qz = parent[2 * W + k]
        dx = x[k] - qx
        dy = x[W + k] - qy
        dz = x[2 * W + k] - qz
        size = math.sqrt(max(dx * dx + dy * dy + dz * dz, tiny))
        # what flew off so far that its square overflows must not come back as a strand of no length: 0 * inf is NaN
        f = length[k] / size + zero * size
        x[k] = qx + dx * f
        x[W + k] = qy + dy * f
        x[2 * W + k] = qz + dz * f


def passes(parameters: Parameters, scene: Any) -> list[Pass]:
    """One pass."""

    def prepare(moment: Moment) -> Any:
        import numpy as np

        return np.array([1e-36, 0.0], np.float32)

    return [Pass(apply, prepare)]
