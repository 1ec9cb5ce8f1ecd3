"""Long hair that swings at the steps of a film: a limp strand of a quarter of a metre, let go a third of a right angle
aside, loses nothing.

Its first mode is that of a hanging chain (Bernoulli 1733), to which a chain let go straight comes near. Energy is read
from how high the strand comes where it turns: no solver has to tell its velocities.
"""

from __future__ import annotations

import math

from .base import Case, G, Reference, Track, groom, preset
from .chain import shapes
from .swing import errors

LENGTH = 0.25
"""Metres, of hair to the shoulders; at 24 steps a second ω h is .31, 20 steps a cycle."""
TILT = math.pi / 36
"""Radians: five degrees, for frequencies grow with the square of it."""


def exact() -> dict[str, float]:
    """ω, in 1/s, of the first mode."""
    return {"ω": float(shapes().frequencies[0]) * math.sqrt(G / LENGTH)}


def case(particles: int) -> Case:
    """One strand that bends freely, in air that does not slow it."""
    return Case(preset(0.0, 1, particles), groom([[math.sin(TILT), -math.cos(TILT), 0]], [LENGTH]))


def measure(track: Track) -> dict[str, float | None]:
    """``loss``: share of the first mode's amplitude lost in a cycle; ``frequency 1``; ``swing``: both, as the error of
    a complex frequency; ``growth``: highest rise of the centre of mass above where it was let go, as a share of the
    length, which is energy over m g L."""
    found = errors(shapes(), math.sqrt(G / LENGTH), Track(track.times, track.positions / LENGTH), axis=0)
    height = track.positions[:, 0, :, 1]
    centre = ((height[:, 1:] + height[:, :-1]) / 2).mean(1) - height[:, 0]
    rise = max(0.0, float(centre.max() - centre[0]))
    return {name: found[name] for name in ("swing", "loss", "frequency 1")} | {"growth": rise / LENGTH}


REFERENCE = Reference(
    name="swing",
    title="hair that swings at the steps of a film",
    metric="swing",
    unit="of the frequency",
    needs=("inertia",),
    span=6.0,
    exact=exact,
    case=case,
    measure=measure,
    moving=True,
    steps={"rod": (1 / 24, 1 / 48, 1 / 96, 1 / 192), "foil": (1 / 480, 1 / 960, 1 / 1920, 1 / 3840)},
)
