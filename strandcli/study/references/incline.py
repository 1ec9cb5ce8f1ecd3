"""Friction between strands: one that lies across others, down a slope, begins to slide at the angle atan µ (Coulomb).

Each of several slopes has rails, short strands straight down it, and a long one that lies across them and is
clamped at its root. What friction does not hold of its weight along the slope bends it downhill, in proportion to
tan (slope) − µ. Slopes are a degree apart, and as many are flatter than atan µ as steeper: the distance of tips on the
steeper ones, drawn on to where it vanishes, is the angle. What the first touch moves on the flatter ones before it
sticks is less than any of these distances.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...groom.record import Groom
from .base import Case, Errors, Reference, Track, groom, preset

MU = 0.4
ANGLE = math.degrees(math.atan(MU))
BENDING = 2.0
"""B / (ρ A), m⁴/s²: rails bend by hundredths of a degree, and the tip of what slides goes millimetres and more."""
OFF = tuple(np.arange(-3.5, 4.0).tolist())
"""Degrees of the slopes beyond atan µ."""
RAILS = (0.2, 0.4, 0.6, 0.8, 1.0)
"""Where rails cross the long strand, metres from its root."""
RAIL = 0.1
"""Length of a rail, metres; that of the long strand is a metre."""
THICKNESS = 0.002
STEEPER = 5e-3
"""Metres that the tip has to move further for a degree more, at least: some 13 mm where friction does nothing but what
Coulomb's law says."""
APART = 2.0
"""Metres between slopes."""


def angles() -> NDArray[np.float64]:
    """The slopes, radians."""
    return np.asarray(math.atan(MU) + np.radians(OFF))


def strands() -> Groom:
    """The strands of all slopes, the long one of each first. x leads along the long ones."""
    roots, directions, lengths = [], [], []
    for k, angle in enumerate(angles()):
        down = np.array([0.0, -math.sin(angle), math.cos(angle)])
        up = np.array([0.0, math.cos(angle), math.sin(angle)])
        origin = np.array([0.0, 0.0, APART * k])
        roots.append(origin + THICKNESS * up)
        directions.append(np.array([1.0, 0.0, 0.0]))
        lengths.append(1.0)
        for x in RAILS:
            roots.append(origin + np.array([x - 0.01, 0.0, 0.0]) - RAIL / 2 * down)
            directions.append(down)
            lengths.append(RAIL)
    return groom(np.array(directions), lengths, np.array(roots))


def case(particles: int) -> Case:
    """All slopes at once."""
    made = strands()
    settings = preset(BENDING, made.strands, particles, drag=5.0)
    settings["rules"].append({"contact": {"thickness": THICKNESS, "friction": MU}})
    return Case(settings, made)


def measure(track: Track) -> Errors:
    """``angle``: error of the angle at which strands begin to slide, as a share. None where a strand on a slope flatter
    than atan µ moves as far as one on a steeper slope, or where steeper slopes do not bring strands further."""
    rows = slice(None, None, 1 + len(RAILS))
    distances = np.linalg.norm(track.last[rows, -1] - track.positions[0, rows, -1], axis=1)
    off = np.array(OFF)
    steep = off > 0
    each, level = np.polyfit(off[steep], distances[steep], 1)
    if distances[~steep].max() >= distances[steep].min() or each < STEEPER:
        return {"angle": None}
    return {"angle": abs(float(level / each)) / ANGLE}


INCLINE = Reference(
    name="incline", title="a strand across others begins to slide at atan µ", metric="angle", unit="of the angle",
    needs="bending stiffness in physical units, contact between strands", span=1.0,
    exact=lambda: {"angle": ANGLE}, case=case, measure=measure, particles=(11, 21),
)  # fmt: skip
