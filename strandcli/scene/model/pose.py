"""Positions and orientations over time."""

from __future__ import annotations

from dataclasses import dataclass

from ..fields import Vector, choice, number, vector


@dataclass(frozen=True, slots=True, repr=False)
class PoseKey:
    """A position and an orientation at one moment."""

    time: float = number(0.0, unit="s", doc="frame 1 is at 0")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="translation")
    rotation: Vector = vector((0.0, 0.0, 0.0), unit="deg", doc="Euler angles about x, then y, then z; may exceed 360")
    ease: str = choice("smooth", ("smooth", "linear", "step"), doc="interpolation to the next key")
