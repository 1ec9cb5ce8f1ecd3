"""Gravity: p_i' = p_i + g Δt² (thesis §2). There is no velocity in the source: speed is g Δt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ...scene.fields import Vector, vector
from .rule import Moment, Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

name = "gravity"
order = 10.0


@dataclass(frozen=True, slots=True)
class Parameters:
    """The same pull on every particle but the root."""

    acceleration: Vector = vector((0.0, -9.81, 0.0), unit="m/s²", doc="acceleration")


def apply(a: Any, b: Any, c: Any, length: Any, p: Any) -> Any:
    """Return a particle's place after gravity; p: g Δt², metres."""
    return a[0] + p[0], a[1] + p[1], a[2] + p[2]


def idle(parameters: Parameters, scene: Scene) -> str:
    """Why this rule has nothing to do, or nothing."""
    return "" if any(parameters.acceleration) else "its acceleration is zero"


def passes(parameters: Parameters, scene: Scene) -> list[Pass]:
    """One pass."""

    def prepare(moment: Moment) -> Any:
        import numpy as np

        return np.array([a * moment.step**2 for a in parameters.acceleration], np.float32)

    return [Pass(apply, prepare, "lane", 3)]
