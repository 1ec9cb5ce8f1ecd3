"""Rods with an oval section: how far they bend across each axis and askew, and how fast they swing about both.

Gravity sets in on level rods, so little of it that the swing stays in the linear range: each swings about its own rest,
along both axes of its section, as a beam with the rigidity E π a³ b / 4 does along the half axis a. The wide axis of
one is level, of one upright, and of one half way, which is pulled aside, out of the load's plane.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...groom.record import Groom
from .base import Case, Reference, Track, greatest, groom, preset
from .beam import GAMMA, rigidity, shapes
from .exact.quadrature import Array
from .swing import STEPS, Swing, oscillation

RATIO = 2.0
"""Of the axes: along the wide one a swing takes half the time."""
ANGLES = (0.0, 0.5, 1.0)
"""Of the wide axis above the level, in right angles, a rod each."""
AXES = ("thin", "wide")
ASKEW = math.pi / 4


def frequency(axis: str) -> float:
    """Of the first mode along an axis, 1/s."""
    slow = float(shapes().frequencies[0]) * math.sqrt(rigidity())
    return slow if axis == "thin" else RATIO * slow


def deflection(axis: str) -> float:
    """Of a tip at rest under a pull along an axis, metres: q L⁴ / (8 B)."""
    return GAMMA / 8 / (1.0 if axis == "thin" else RATIO**2)


def exact() -> dict[str, float]:
    """Frequencies in 1/s, and deflections of the askew rod over its length: down, and aside."""
    thin, wide = (math.sin(ASKEW) ** 2 * deflection(axis) for axis in AXES)
    found = {f"ω {axis}": frequency(axis) for axis in AXES}
    return found | {"down": thin + wide, "aside": thin - wide}


def case(particles: int) -> Case:
    """Three level strands of a metre."""
    tones = -np.array(ANGLES, np.float32)
    made: Groom = replace(groom([[1.0, 0, 0]] * len(ANGLES), [1.0] * len(ANGLES)), tones=tones)
    settings = preset(rigidity(), len(ANGLES), particles, gravity=GAMMA * rigidity())
    settings["rod"] |= {"section": {"wide": RATIO, "thin": 1.0, "spread": 90.0}, "torsion": 0.75}
    return Case(settings, made)


def middle(times: Array, values: Array, swings: list[Swing]) -> float:
    """What values (T,) swing about with all of these swings."""
    t = times - times[0]
    waves = [np.exp(-decay * t) * wave(omega * t) for omega, decay in swings for wave in (np.cos, np.sin)]
    return float(np.linalg.lstsq(np.stack([np.ones_like(t), *waves], 1), values, rcond=None)[0][0])


def measure(track: Track) -> dict[str, float | None]:
    """``thin`` and ``wide``: errors of the complex frequency ω + i λ along each axis, of its own rod; ``askew``: the
    greatest along either axis of the rod that is pulled askew; ``swing``, the worst of these; ``loss``: of the
    amplitude along the thin axis in a cycle; ``deflection``: how far from its place the askew rod's tip rests, over how
    far it is bent."""
    out: dict[str, float | None] = {}
    rests: list[float | None] = []
    for rod, axis, name in ((0, "thin", "thin"), (2, "wide", "wide"), (1, "thin", "askew"), (1, "wide", "askew")):
        angle = ANGLES[rod] * math.pi / 2
        down, level = (math.cos(angle), math.sin(angle)) if axis == "thin" else (math.sin(angle), -math.cos(angle))
        along = level * track.positions[:, rod, :, 2] - down * track.positions[:, rod, :, 1]
        ω = frequency(axis)
        swing = oscillation(track.times, shapes().shares(along)[:, 0], ω)
        error = None if swing is None else math.hypot(swing[0] - ω, swing[1]) / ω
        out[name] = greatest([out[name], error]) if name in out else error
        if name == "thin":
            out["loss"] = None if swing is None else abs(math.expm1(-2 * math.pi * swing[1] / swing[0]))
        if name == "askew":
            goal = down * deflection(axis)
            rests.append(None if swing is None else middle(track.times, along[:, -1], [swing]) - goal)
    bent = math.hypot(*(math.sin(ASKEW) * deflection(axis) for axis in AXES))
    known = [one for one in rests if one is not None]
    out["deflection"] = math.hypot(*known) / bent if len(known) == len(rests) else None
    return {"swing": greatest([out["thin"], out["wide"], out["askew"]]), **out}


REFERENCE = Reference(
    name="section",
    title="rods with an oval section, across each axis and askew",
    metric="swing",
    unit="of the frequency",
    needs=("bending", "inertia", "section"),
    span=4.0,
    exact=exact,
    case=case,
    measure=measure,
    moving=True,
    steps=STEPS,
)
