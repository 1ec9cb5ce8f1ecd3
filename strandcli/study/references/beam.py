"""A clamped beam's frequencies: gravity sets in on a level rod and every mode of it swings about its own rest.

So little gravity that the swing stays in the linear range. Each mode's share of the deflection swings at that mode's
frequency alone, and tells it.
"""

from __future__ import annotations

import math
from functools import cache

from .base import Case, Reference, Track, groom, preset
from .exact import modes
from .swing import COUNT, STEPS, errors

GAMMA = 0.02
SLOWEST = 2 * math.pi
"""Angular frequency of the first mode, rad/s: a swing a second."""


@cache
def shapes() -> modes.Modes:
    """The exact modes of a beam of length 1, frequencies in √(B / (ρ A L⁴))."""
    return modes.beam(COUNT)


def rigidity() -> float:
    """B / (ρ A) that makes the first mode of one metre as slow as it should be."""
    return float((SLOWEST / shapes().frequencies[0]) ** 2)


def exact() -> dict[str, float]:
    """β² of each mode: ω = β² √(B / (ρ A L⁴))."""
    return {f"β² {i + 1}": float(value) for i, value in enumerate(shapes().frequencies)}


def case(particles: int) -> Case:
    """One level strand of a metre."""
    return Case(preset(rigidity(), 1, particles, gravity=GAMMA * rigidity()), groom([[1, 0, 0]], [1.0]))


def measure(track: Track) -> dict[str, float | None]:
    """Relative errors of the frequencies, and ``loss``: the share of the first mode's amplitude lost in a cycle."""
    return errors(shapes(), math.sqrt(rigidity()), track, axis=1)


REFERENCE = Reference(
    name="beam",
    title="frequencies of a clamped beam",
    metric="swing",
    unit="of the frequency",
    needs=("bending", "inertia"),
    span=4.0,
    exact=exact,
    case=case,
    measure=measure,
    moving=True,
    steps=STEPS,
)
