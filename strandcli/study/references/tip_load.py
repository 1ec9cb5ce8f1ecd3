"""The elastica with a load on its tip: a level rod that hardly weighs anything carries a mass at its end."""

from __future__ import annotations

from .base import Reference, Track, greatest
from .exact.elastica import hang
from .level import LevelRods

MASS = 10.0
"""On the tip, in strand masses. The strand's own weight, Γ = α / 10, is in the exact solution as well."""
RODS = LevelRods(loads=(1.0, 2.0, 5.0, 10.0), shape=lambda load: hang(load / MASS, load), tip_mass=MASS)


def exact() -> dict[str, float]:
    """Tip places as shares of the length."""
    tips = {load: shape.tip for load, shape in zip(RODS.loads, RODS.shapes, strict=True)}
    return {f"{axis}/L α={load:g}": tip[i] for load, tip in tips.items() for i, axis in enumerate("xy")}


def measure(track: Track) -> dict[str, float | None]:
    """``tip``: greatest distance of a tip from its exact place, and each strand's, as shares of the length."""
    away = RODS.away(track)
    each = {f"tip α={load:g}": one for load, one in zip(RODS.loads, away, strict=True)}
    return {"tip": greatest([*away]), **each}


REFERENCE = Reference(
    name="tip_load",
    title="elastica with a load on its tip, α from 1 to 10",
    metric="tip",
    unit="of the length",
    needs=("bending", "tip mass"),
    span=20.0,
    exact=exact,
    case=RODS.case,
    measure=measure,
)
