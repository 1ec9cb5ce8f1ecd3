"""The heavy elastica: level rods of several lengths that sag under their own weight."""

from __future__ import annotations

from .base import Reference, Track, greatest, off
from .exact.elastica import hang
from .level import LevelRods

RODS = LevelRods(loads=(0.1, 1.0, 3.0, 10.0, 30.0, 100.0), shape=hang)


def exact() -> dict[str, float]:
    """H / W, how far down the tip is over how far out, for each Γ."""
    return {f"H/W Γ={load:g}": shape.droop for load, shape in zip(RODS.loads, RODS.shapes, strict=True)}


def measure(track: Track) -> dict[str, float | None]:
    """``tip``: greatest distance of a tip from its exact place, as a share of the length; the error of each H / W."""
    out: dict[str, float | None] = {"tip": greatest([*RODS.away(track)])}
    for load, tip, shape in zip(RODS.loads, RODS.tips(track), RODS.shapes, strict=True):
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
    case=RODS.case,
    measure=measure,
)
