"""Level rods at rest: strands of one material and of several lengths, each of which is another load in a single run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .base import Case, G, Track, groom, preset
from .exact.elastica import Shape

METRE = 10.0
"""The load of a strand of one metre; it grows with the cube of the length."""


@dataclass(frozen=True)
class LevelRods:
    """Strands along x under their own weight, or also under a mass on each tip."""

    loads: tuple[float, ...]
    """Γ = ρ A g L³ / B, or with a mass on the tip α = P L² / B."""
    shape: Callable[[float], Shape]
    """The exact one under a load, of length 1."""
    tip_mass: float = 0.0
    """In strand masses."""

    @cached_property
    def lengths(self) -> NDArray[np.float64]:
        """(strands,) metres."""
        return np.cbrt(np.array(self.loads) / METRE)

    @cached_property
    def shapes(self) -> tuple[Shape, ...]:
        """The exact ones, of length 1."""
        return tuple(self.shape(load) for load in self.loads)

    def case(self, particles: int) -> Case:
        """The strands as they begin: straight. The drag lets them come to rest."""
        count = len(self.loads)
        rigidity = (self.tip_mass or 1.0) * G / METRE
        made = groom([[1, 0, 0]] * count, self.lengths)
        return Case(preset(rigidity, count, particles, drag=2.0), made, tip_mass=self.tip_mass)

    def tips(self, track: Track) -> NDArray[np.float64]:
        """(strands, 3) where a run's tips end, from their roots, in lengths."""
        last = track.last
        return np.asarray((last[:, -1] - last[:, 0]) / self.lengths[:, None])

    def away(self, track: Track) -> list[float]:
        """How far each tip is from its exact place, as a share of the length."""
        goals = np.array([(*shape.tip, 0.0) for shape in self.shapes]) * (1, -1, 1)
        return [float(one) for one in np.linalg.norm(self.tips(track) - goals, axis=1)]
