"""What a reference is: a scene for one kind of strand, its exact behaviour, and a measure of any run.

The measure sees nothing but particles over time, so that every solver could be measured by the same code.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...groom.record import Groom

Array = NDArray[np.float64]
G = 9.81
"""Gravity in all references, m/s²."""
DENSITY, RADIUS = 1000.0, 0.01
"""Of all references' rods, kg/m³ and m; their modulus is what the rigidity asks for."""
Errors = dict[str, float | None]
"""By metric, as shares; None where a run does not hold the quantity at all."""


@dataclass(frozen=True)
class Track:
    """A recorded run."""

    times: NDArray[np.float64]
    """(T,) seconds."""
    positions: NDArray[np.float64]
    """(T, strands, particles, 3) metres."""

    @property
    def last(self) -> Array:
        """(strands, particles, 3) at the end."""
        return np.asarray(self.positions[-1])


@dataclass(frozen=True)
class Case:
    """What a solver is given to start with."""

    settings: Mapping[str, Any]
    """A preset as plain data."""
    groom: Groom
    tip_mass: float = 0.0
    """On the last particle, in units of a strand's own mass."""


@dataclass(frozen=True)
class Reference:
    """An exact solution. Errors are shares: of the exact value, or of a strand's length where it says so."""

    name: str
    title: str
    """One line for people."""
    metric: str
    """The error that settings are chosen by; `measure` gives it among more."""
    unit: str
    """What the metric is a share of."""
    needs: str
    """What the solver thesis does not represent of it."""
    span: float
    """Seconds that a run takes."""
    exact: Callable[[], dict[str, float]]
    """The exact quantities by name."""
    case: Callable[[int], Case]
    """The scene for a number of particles."""
    measure: Callable[[Track], Errors]
    """Errors of a run."""
    moving: bool = False
    """Whether the motion is measured, at every step, and not only the end."""
    steps: tuple[float, ...] = (1 / 24, 1 / 60, 1 / 240)
    """Steps in seconds to try."""
    particles: tuple[int, ...] = (6, 10, 19)
    """Particles a strand to try."""


def preset(
    rigidity: float, strands: int, particles: int, gravity: float = G, drag: float = 0.0, **more: Any
) -> dict[str, Any]:
    """A preset of rods in a field of gravity and nothing else. ``rigidity`` is B / (ρ A) in m⁴/s²."""
    return {
        "seed": 0, "time": {"preroll": 0},
        "emitter": {"shape": {"kind": "disc", "radius": 1e-6}, "strands": strands, "particles": particles, **more},
        "rules": [{"gravity": {"acceleration": [0.0, -gravity, 0.0]}}, "elasticity"],
        "rod": {
            "density": DENSITY, "radius": RADIUS, "young": max(4 * DENSITY * rigidity / RADIUS**2, 1e-9),
            "rest": "straight", "drag": drag, "damping": 0.0, "friction": 0.0,
        },
    }  # fmt: skip


def groom(
    directions: NDArray[np.floating] | list[list[float]],
    lengths: NDArray[np.floating] | list[float],
    roots: NDArray[np.floating] | None = None,
) -> Groom:
    """Straight strands: directions (strands, 3), lengths (strands,) metres, roots (strands, 3) metres, by default at
    the origin."""
    unit = np.array(directions, np.float64)
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    count = len(lengths)
    return Groom(
        np.zeros((count, 3), np.float32) if roots is None else np.asarray(roots, np.float32), unit.astype(np.float32),
        np.asarray(lengths, np.float32), np.zeros(count, np.float32),
    )  # fmt: skip


def off(measured: float, exact: float) -> float:
    """The relative error of a measured value."""
    return abs(measured / exact - 1)
