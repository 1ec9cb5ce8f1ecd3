"""Self-buckling: upright rods of several lengths, clamped a hundredth of a radian off the vertical.

Past Γ_c = 7.837 a rod bows under its own weight. A solver's load is where its tip is pushed out by a set share of the
length, between two strands; the exact one is that of the elastica with the same tilt and push.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from .base import Case, G, Reference, Track, groom, off, preset
from .exact import elastica

TILT = 0.01
OUT = 0.35
"""How far out the tip is at the load that is sought, as a share of the length: clearly bowed, and soon at rest."""
LOADS = np.linspace(6.8, 9.2, 25)
LENGTHS = np.cbrt(LOADS / 8)


@cache
def curve() -> tuple[float, ...]:
    """How far out the exact tips are, as shares of the length."""
    return tuple(elastica.hang(load, clamp=np.pi - TILT, nodes=48).tip[0] for load in LOADS)


def exact() -> dict[str, float]:
    """The load of an upright rod, and that of this tilt and push."""
    return {"Γ_c": elastica.buckling_load(), f"Γ at {OUT:g} L": _crossing(np.array(curve())) or 0.0}


def _crossing(out: np.ndarray) -> float | None:
    """The least load at which the tip is OUT far out, between strands by a line; None where none is, or all are."""
    beyond = np.flatnonzero(out >= OUT)
    if not len(beyond) or beyond[0] == 0 or not np.isfinite(out).all():
        return None
    after = int(beyond[0])
    share = (OUT - out[after - 1]) / (out[after] - out[after - 1])
    return float(LOADS[after - 1] + share * (LOADS[after] - LOADS[after - 1]))


def case(particles: int) -> Case:
    """Upright strands along y, leaning to x."""
    count = len(LOADS)
    way = [[np.sin(TILT), np.cos(TILT), 0.0]] * count
    return Case(preset(G / 8, count, particles, drag=2.0), groom(way, LENGTHS))


def measure(track: Track) -> dict[str, float | None]:
    """``load``: relative error of the buckling load."""
    out = (track.last[:, -1, 0] - track.last[:, 0, 0]) / LENGTHS
    found = _crossing(out)
    return {"load": None if found is None else off(found, exact()[f"Γ at {OUT:g} L"])}


REFERENCE = Reference(
    name="buckling",
    title="self-buckling of upright rods",
    metric="load",
    unit="of the load",
    needs=("bending",),
    span=40.0,
    exact=exact,
    case=case,
    measure=measure,
    steps={"foil": (1 / 240, 1 / 480, 1 / 960)},  # bowing takes long, and its steps are many
)
