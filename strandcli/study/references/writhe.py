"""Writhe: a straight rod, clamped at both ends along one line, whose far end is brought nearer and turned.

Part of the turns twists the rod, and the rest bends it out of its plane: turns = twist + writhe (Călugăreanu, White,
Fuller). The form is that of Kirchhoff's equations with the ends so far apart and so far turned.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...groom.record import Groom
from .base import Case, Reference, Track, off, preset
from .exact import twisted

APART, TURNS, TORSION = 0.9, 2.0, 0.75
"""Distance of the ends over the length, which is one metre; turns; GJ over EI."""
BUMP = 0.02
"""Radians by which the strand is bent at the start, between a quarter and three quarters of its length, so that it has
a side to bow to."""
BEGUN, DONE = 1.0, 4.0
"""Seconds at which the end has come nearer, and at which it has been turned."""


def exact() -> dict[str, float]:
    """Writhe in turns, and how far the rod bows from the line between its ends."""
    found = form()
    bow = float(np.hypot(found.places[:, 1], found.places[:, 2]).max())
    return {"writhe": TURNS - found.twist / (2 * math.pi), "bow": bow}


def form() -> twisted.Twisted:
    """The exact form."""
    return twisted.solve(APART, 2 * math.pi * TURNS, TORSION)


def case(particles: int) -> Case:
    """A strand along x, all but straight."""
    shares = (np.arange(particles - 1) + 0.5) / (particles - 1)
    bend = np.where(abs(shares - 0.5) < 0.25, BUMP * np.sin(4 * math.pi * (shares - 0.25)), 0.0)
    edges = np.stack([np.cos(bend), np.sin(bend), 0 * bend], 1)
    made = Groom(
        np.zeros((1, 3), np.float32), np.array([[1, 0, 0]], np.float32), np.ones(1, np.float32),
        np.zeros(1, np.float32), ways=edges[None],
    )  # fmt: skip
    settings = preset(0.1, 1, particles, gravity=0.0, drag=20.0)
    place = (APART - float(edges[:, 0].mean()), -float(edges[:, 1].mean()), 0.0)
    settings["rod"] |= {
        "end": "clamped",
        "torsion": TORSION,
        "precision": "double",
        "end_keys": [
            {"time": 0.0, "ease": "linear"},
            {"time": BEGUN, "position": place, "ease": "linear"},
            {"time": DONE, "position": place, "turns": TURNS},
        ],
    }
    return Case(settings, made)


def writhe(strand: NDArray[np.float64]) -> float:
    """Of particles (N + 1, 3) between ends along x, in turns and between halves of one: the angle by which a frame that
    is transported along the strand turns backward (Fuller 1978)."""
    edges = np.diff(strand, axis=0)
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    way = np.array([1.0, 0.0, 0.0])
    t, a = way, np.array([0.0, 1.0, 0.0])
    for e in (*edges, way):
        a = a - (a @ e) / (1 + t @ e) * (t + e)
        t = e
    return math.atan2(a[2], a[1]) / (2 * math.pi)


def measure(track: Track) -> dict[str, float | None]:
    """``shape``: greatest distance of a particle from its exact place along the line of the ends and across it, about
    which the rod as a whole may turn, as a share of the length; ``writhe``: relative."""
    strand, goal = track.last[0] - track.last[0, 0], form().places
    at = np.linspace(0, 1, len(goal))
    shares = np.linspace(0, 1, len(strand))
    along = strand[:, 0] - np.interp(shares, at, goal[:, 0])
    across = np.hypot(strand[:, 1], strand[:, 2]) - np.interp(shares, at, np.hypot(goal[:, 1], goal[:, 2]))
    away = float(np.hypot(along, across).max())
    return {"shape": away, "writhe": off(writhe(strand), exact()["writhe"])}


REFERENCE = Reference(
    name="writhe",
    title="a rod clamped at both ends, brought nearer and turned",
    metric="shape",
    unit="of the length",
    needs=("bending", "two ends", "twist", "turned end"),
    span=8.0,
    exact=exact,
    case=case,
    measure=measure,
    particles=(11, 21, 41),
)
