"""The elastica with a load on its tip: a level rod that hardly weighs anything carries a mass at its end."""

from __future__ import annotations

from functools import cache

import numpy as np

from .. import elastica
from .base import Case, G, Reference, Track, greatest, groom, preset

LOADS = (1.0, 2.0, 5.0, 10.0)
"""α = P L² / B of the strands."""
MASS = 10.0
"""On the tip, in strand masses. The strand's own weight, Γ = α / 10, is in the exact solution as well."""
LENGTHS = np.cbrt(np.array(LOADS) / 10)


@cache
def shapes() -> tuple[elastica.Shape, ...]:
    """The exact ones, of length 1."""
    return tuple(elastica.hang(load / MASS, load) for load in LOADS)


def exact() -> dict[str, float]:
    """Tip places as shares of the length."""
    tips = {load: shape.tip for load, shape in zip(LOADS, shapes(), strict=True)}
    return {f"{axis}/L α={load:g}": tip[i] for load, tip in tips.items() for i, axis in enumerate("xy")}


def case(particles: int) -> Case:
    """Level strands along x; P L² / B = MASS · Γ."""
    count = len(LOADS)
    made = groom([[1, 0, 0]] * count, LENGTHS)
    return Case(preset(MASS * G / 10, count, particles, drag=2.0), made, tip_mass=MASS)


def measure(track: Track) -> dict[str, float | None]:
    """``tip``: greatest distance of a tip from its exact place, and each strand's, as shares of the length."""
    tips = (track.last[:, -1] - track.last[:, 0]) / LENGTHS[:, None]
    goals = np.array([(*shape.tip, 0.0) for shape in shapes()]) * (1, -1, 1)
    away = [float(one) for one in np.linalg.norm(tips - goals, axis=1)]
    return {
        "tip": greatest([*away]),
        **{f"tip α={load:g}": one for load, one in zip(LOADS, away, strict=True)},
    }


REFERENCE = Reference(
    name="tip_load",
    title="elastica with a load on its tip, α from 1 to 10",
    metric="tip",
    unit="of the length",
    needs=("bending", "tip mass"),
    span=20.0,
    exact=exact,
    case=case,
    measure=measure,
)
