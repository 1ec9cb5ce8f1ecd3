"""Twist: a straight rod, clamped at both ends, coils when one end is turned hard enough (Greenhill 1883).

Its end has to be free to come nearer, for a strand that keeps its length cannot coil between ends that stay. No solver
here has ends that slide, so that none can be measured: every one of them reads "not represented". `spring`, `michell`
and `writhe` measure twist.
"""

from __future__ import annotations

import math

import numpy as np

from ...errors import UsageError
from .base import Case, Reference, Track, groom, preset


def moment() -> float:
    """M L / B at which it coils: 2 x with x the least positive root of tan x = x, by bisection."""
    low, high = math.pi, 1.5 * math.pi - 1e-9
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if math.sin(middle) < middle * math.cos(middle) else (middle, high)
    return 2 * low


def exact() -> dict[str, float]:
    """The moment in B / L."""
    return {"M L / B": moment()}


def case(particles: int) -> Case:
    """A straight strand of a metre."""
    return Case(preset(1.0, 1, particles), groom(np.array([[1.0, 0, 0]]), [1.0]))


def measure(track: Track) -> dict[str, float | None]:
    """Particles tell nothing about twist. Raises `UsageError`."""
    raise UsageError("reference twist: positions of particles do not tell how a strand is twisted")


REFERENCE = Reference(
    name="twist",
    title="a twisted rod that coils",
    metric="moment",
    unit="of the moment",
    needs=("bending", "two ends", "twist", "turned end", "sliding end"),
    span=20.0,
    exact=exact,
    case=case,
    measure=measure,
)
