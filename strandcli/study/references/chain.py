"""A hanging chain's frequencies (Bernoulli 1733): a limp strand, let go a little off the vertical."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from .base import Case, G, Reference, Track, groom, preset
from .exact import modes
from .swing import COUNT, STEPS, errors

TILT = 0.02


@cache
def shapes() -> modes.Modes:
    """The exact modes of a chain of length 1, frequencies in √(g / L)."""
    return modes.chain(COUNT)


def exact() -> dict[str, float]:
    """ω √(L / g) of each mode: half the zeros of the Bessel function J₀."""
    return {f"ω {i + 1}": float(value) for i, value in enumerate(shapes().frequencies)}


def case(particles: int) -> Case:
    """One strand of a metre that bends freely."""
    return Case(preset(0.0, 1, particles), groom([[np.sin(TILT), -np.cos(TILT), 0]], [1.0]))


def measure(track: Track) -> dict[str, float | None]:
    """Relative errors of the frequencies, and ``loss``: the share of the first mode's amplitude lost in a cycle."""
    return errors(shapes(), math.sqrt(G), track, axis=0)


REFERENCE = Reference(
    name="chain",
    title="frequencies of a hanging chain",
    metric="swing",
    unit="of the frequency",
    needs=("inertia",),
    span=6.0,
    exact=exact,
    case=case,
    measure=measure,
    moving=True,
    steps=STEPS,
)
