"""Stiffness: p_i' = p_i + k (d_1 − d_2), a segment is turned toward the one before it (thesis §2).

k = (l − i) s Δt², d_1 = p_{i−1} − p_{i−2}, d_2 = p_i − p_{i−1}; for i = 1, d_1 = L d.

Erratum: for k > 1 the source prints p_i' = p_i (d_1 − d_2), a product of lengths. Meant is k = min(k, 1): the segment
takes over the whole direction of the one before it, and no more. Unclamped the rule diverges from k = 2.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ...scene.fields import boolean, number
from .rule import Moment, Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

name = "stiffness"
order = 30.0


@dataclass(frozen=True, slots=True)
class Parameters:
    """Stiffest at the root, as (l - i)."""

    strength: float = number(50.0, low=0, unit="1/s²", doc="s; k = (l - i) s Δt²")
    clamp: bool = boolean(True, doc="keep k at most 1; without it the rule diverges from k = 2")


def apply(a: Any, b: Any, c: Any, length: Any, p: Any) -> Any:
    """Return a particle's place turned toward the segment before; p: k of this particle."""
    (k,) = p
    return (
        a[0] + k * (b[0] - c[0] - (a[0] - b[0])),
        a[1] + k * (b[1] - c[1] - (a[1] - b[1])),
        a[2] + k * (b[2] - c[2] - (a[2] - b[2])),
    )


def idle(parameters: Parameters, scene: Scene) -> str:
    """Why this rule has nothing to do, or nothing."""
    return "" if parameters.strength > 0 else "its strength is zero"


def passes(parameters: Parameters, scene: Scene) -> list[Pass]:
    """One pass."""
    import numpy as np

    n = scene.emitter.particles

    @functools.lru_cache(maxsize=8)
    def factors(step: float) -> Any:
        k = (n - np.arange(n)) * parameters.strength * step**2
        return (np.minimum(k, 1.0) if parameters.clamp else k).astype(np.float32)[:, None]

    def prepare(moment: Moment) -> Any:
        return factors(moment.step)

    return [Pass(apply, prepare, "lane", 1, per_particle=True)]
