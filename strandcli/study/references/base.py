"""What a reference is: a scene for one kind of strand, its exact behaviour, and a measure of any solver's run.

The measure sees nothing but particles over time, so that all solvers are measured by the same code.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...groom.record import Groom

G = 9.81
"""Gravity in all references, m/s²."""
DENSITY, RADIUS = 1000.0, 0.01
"""Of all references' rods, kg/m³ and m; their modulus is what the rigidity asks for."""

NEEDS = {
    "bending": "bending stiffness in physical units",
    "inertia": "inertia",
    "tip mass": "a mass on the tip",
    "two ends": "a strand held at both ends",
    "twist": "twist",
    "contact": "contact between strands",
    "interaction": "strands that push each other apart",
}
"""What a solver may have to represent, in words."""


@dataclass(frozen=True)
class Track:
    """A recorded run."""

    times: NDArray[np.float64]
    """(T,) seconds."""
    positions: NDArray[np.float64]
    """(T, strands, particles, 3) metres."""

    @property
    def last(self) -> NDArray[np.float64]:
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
    tip_held_at: tuple[float, float, float] | None = None
    """Where the last particle is brought to and held, metres."""


@dataclass(frozen=True)
class Reference:
    """An exact solution. Errors are shares: of the exact value, or of a strand's length where it says so."""

    name: str
    title: str
    """One line for people."""
    metric: str
    """The error that settings are chosen by; `measure` gives it among others."""
    unit: str
    """What the metric is a share of."""
    needs: tuple[str, ...]
    """Keys of `NEEDS`: what a solver has to represent."""
    span: float
    """Seconds that a run takes."""
    exact: Callable[[], dict[str, float]]
    """The exact quantities by name."""
    case: Callable[[int], Case]
    """The scene for a number of particles."""
    measure: Callable[[Track], dict[str, float | None]]
    """Errors of a run by metric; None where the run does not hold the quantity at all."""
    moving: bool = False
    """Whether the motion is measured, at every step, and not only the end."""
    steps: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    """Steps in seconds to try, by solver, where they are not the usual ones."""
    particles: tuple[int, ...] = (6, 10, 19)
    """Particles a strand to try."""


def preset(
    rigidity: float, strands: int, particles: int, gravity: float = G, drag: float = 0.0, **more: Any
) -> dict[str, Any]:
    """A preset of rods in a field of gravity and nothing else. ``rigidity`` is B / (ρ A) in m⁴/s²."""
    return {
        "seed": 0,
        "time": {"preroll": 0},
        "emitter": {"shape": {"kind": "disc", "radius": 1e-6}, "strands": strands, "particles": particles, **more},
        "rules": [{"gravity": {"acceleration": [0.0, -gravity, 0.0]}}, "elasticity"],
        "rod": {
            "density": DENSITY,
            "radius": RADIUS,
            "young": max(4 * DENSITY * rigidity / RADIUS**2, 1e-9),
            "rest": "straight",
            "drag": drag,
            "damping": 0.0,
            "friction": 0.0,
        },
    }


def groom(directions: NDArray[np.floating] | list[list[float]], lengths: NDArray[np.floating] | list[float]) -> Groom:
    """Straight strands that all begin at the origin: directions (strands, 3), lengths (strands,) metres."""
    way = np.array(directions, np.float64)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    count = len(lengths)
    return Groom(
        np.zeros((count, 3), np.float32),
        way.astype(np.float32),
        np.asarray(lengths, np.float32),
        np.zeros(count, np.float32),
    )


def off(measured: float, exact: float) -> float:
    """The relative error of a measured value."""
    return abs(measured / exact - 1)


def greatest(errors: list[float | None]) -> float | None:
    """The worst of several errors; None where one of them is not to be had."""
    known = [one for one in errors if one is not None]
    return max(known) if len(known) == len(errors) and known else None
