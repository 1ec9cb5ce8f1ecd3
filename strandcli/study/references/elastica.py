"""The heavy elastica: level rods of several lengths that sag under their own weight.

Γ = ρ A g L³ / B grows with the cube of the length, so strands of one material and of different lengths are all loads of
the curve in a single run.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from .. import elastica
from .base import Case, G, Reference, Track, greatest, groom, off, preset

LOADS = (0.1, 1.0, 3.0, 10.0, 30.0, 100.0)
"""Γ of the strands; that of a strand of one metre is 10."""
LENGTHS = np.cbrt(np.array(LOADS) / 10)


@cache
def shapes() -> tuple[elastica.Shape, ...]:
    """The exact ones, of length 1."""
    return tuple(elastica.hang(load) for load in LOADS)


def exact() -> dict[str, float]:
    """H / W, how far down the tip is over how far out, for each Γ."""
    return {f"H/W Γ={load:g}": shape.droop for load, shape in zip(LOADS, shapes(), strict=True)}


def case(particles: int) -> Case:
    """Level strands along x. The drag lets them come to rest."""
    count = len(LOADS)
    return Case(preset(G / 10, count, particles, drag=2.0), groom([[1, 0, 0]] * count, LENGTHS))


def measure(track: Track) -> dict[str, float | None]:
    """``tip``: greatest distance of a tip from its exact place, as a share of the length; the error of each H / W."""
    last = track.last
    tips = (last[:, -1] - last[:, 0]) / LENGTHS[:, None]
    goals = np.array([(*shape.tip, 0.0) for shape in shapes()]) * (1, -1, 1)
    away = np.linalg.norm(tips - goals, axis=1)
    out: dict[str, float | None] = {"tip": greatest([float(one) for one in away])}
    for load, tip, shape in zip(LOADS, tips, shapes(), strict=True):
        out[f"H/W Γ={load:g}"] = off(-tip[1] / tip[0], shape.droop)
    return out


REFERENCE = Reference(
    name="elastica",
    title="heavy elastica: level rods under their own weight, Γ from 0.1 to 100",
    metric="tip",
    unit="of the length",
    needs=("bending",),
    span=20.0,
    exact=exact,
    case=case,
    measure=measure,
)
