"""The catenary: a limp strand between two level points, y = a cosh(x / a), with 2 a sinh(D / (2 a)) = L."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from .base import Case, Errors, Reference, Track, groom, off, preset

APART = 0.7
"""D: distance of the ends, as a share of the length L, which is one metre."""


@cache
def parameter() -> float:
    """a of the catenary, by Newton's method for u = D / (2 a), sinh u / u = L / D."""
    u = math.sqrt(6 * (1 / APART - 1))
    for _ in range(50):
        u -= (math.sinh(u) - u / APART) / (math.cosh(u) - 1 / APART)
    return APART / (2 * u)


def sag() -> float:
    """How deep the middle hangs below the ends."""
    a = parameter()
    return a * (math.cosh(APART / (2 * a)) - 1)


def shape(shares: np.ndarray) -> np.ndarray:
    """(m, 2) across and up from the root, at shares (m,) of the length: s − L/2 = a sinh((x − D/2) / a)."""
    a = parameter()
    x = a * np.arcsinh((np.asarray(shares) - 0.5) / a)
    return np.stack([x + APART / 2, a * (np.cosh(x / a) - np.cosh(APART / (2 * a)))], 1)


def exact() -> dict[str, float]:
    """a and the sag, as shares of the length."""
    return {"a": parameter(), "sag": sag()}


def case(particles: int) -> Case:
    """A strand along x whose tip is brought nearer."""
    return Case(preset(0.0, 1, particles, drag=2.0), groom([[1, 0, 0]], [1.0]), tip_held_at=(APART, 0.0, 0.0))


def measure(track: Track) -> Errors:
    """``shape``: greatest distance of a particle from its exact place, as a share of the length; ``sag``: relative."""
    strand = track.last[0] - track.last[0, 0]
    goal = shape(np.linspace(0, 1, len(strand)))
    away = np.hypot(np.linalg.norm(strand[:, :2] - goal, axis=1), strand[:, 2])
    return {"shape": float(away.max()), "sag": off(-float(strand[:, 1].min()), sag())}


CATENARY = Reference(
    name="catenary", title="catenary: a limp strand held at both ends", metric="shape", unit="of the length",
    needs="a strand held at both ends", span=20.0, exact=exact, case=case, measure=measure, particles=(7, 11, 21),
)  # fmt: skip
