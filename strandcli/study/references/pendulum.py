"""A pendulum let go level: period T = 4 √(L / g) K(sin 45°), and its energy, which it should keep.

A strand of two particles is one. Energy is read where it turns, from how high it comes: no solver has to tell its
velocities.
"""

from __future__ import annotations

import math

import numpy as np

from .base import Case, G, Reference, Track, groom, off, preset

START = math.pi / 2
"""Angle from straight down where it is let go."""


def period(angle: float = START) -> float:
    """Seconds, for one metre: 2 π √(L / g) over the arithmetic-geometric mean of 1 and cos(angle / 2) (Gauss)."""
    a, b = 1.0, math.cos(angle / 2)
    while abs(a - b) > 1e-15 * a:
        a, b = (a + b) / 2, math.sqrt(a * b)
    return 2 * math.pi * math.sqrt(1 / G) / a


def exact() -> dict[str, float]:
    """The period in √(L / g)."""
    return {"period": period() * math.sqrt(G)}


def case(particles: int) -> Case:
    """One level strand of two particles and one metre, whatever was asked for."""
    return Case(preset(0.0, 1, 2), groom([[1, 0, 0]], [1.0]))


def measure(track: Track) -> dict[str, float | None]:
    """``period``: relative; ``loss``: share of the amplitude lost in a cycle; ``swing``: both, as the error of a
    complex frequency; ``growth``: highest rise of the mass above where it was let go, as a share of the length, which
    is energy over m g L."""
    way = track.positions[:, 0, -1] - track.positions[:, 0, 0]
    angles = np.unwrap(np.arctan2(way[:, 0], -way[:, 1]))
    rise = max(0.0, float(way[:, 1].max() - way[0, 1]))
    out: dict[str, float | None] = {"swing": None, "period": None, "loss": None, "growth": rise}
    through = crossings(track.times, angles)
    turns = amplitudes(angles)
    if len(through) > 2:
        out["period"] = off(2 * float(np.mean(np.diff(through))), period())
    if len(turns) > 2:
        kept = float((turns[-1] / START) ** (2 / len(turns)))
        out["loss"] = abs(1 - kept)
        if out["period"] is not None:
            out["swing"] = math.hypot(out["period"], math.log(kept) / (2 * math.pi))
    return out


def crossings(times: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Times at which the angle passes through zero, by the cubic through the four samples around."""
    found = []
    for i in np.flatnonzero(np.sign(angles[1:]) != np.sign(angles[:-1])):
        if not 1 <= i < len(angles) - 2:
            continue
        roots = np.roots(np.polyfit(np.arange(-1.0, 3.0), angles[i - 1 : i + 3], 3))
        real = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > -1e-9) & (roots.real < 1 + 1e-9)]
        if len(real):
            found.append(times[i] + float(real[0]) * (times[i + 1] - times[i]))
    return np.array(found)


def amplitudes(angles: np.ndarray) -> np.ndarray:
    """Sizes of the turning points, by the parabola through three samples."""
    a, b, c = np.abs(angles[:-2]), np.abs(angles[1:-1]), np.abs(angles[2:])
    at = (b > a) & (b >= c) & (b > 0.05)
    a, b, c = a[at], b[at], c[at]
    return np.asarray(b - (c - a) ** 2 / (8 * (a - 2 * b + c)))


REFERENCE = Reference(
    name="pendulum",
    title="pendulum let go level: period and energy",
    metric="swing",
    unit="of the frequency",
    needs=("inertia",),
    span=5.5 * period(),
    exact=exact,
    case=case,
    measure=measure,
    moving=True,
    steps={"rod": (1 / 24, 1 / 60, 1 / 120, 1 / 240, 1 / 480), "foil": (1 / 120, 1 / 240, 1 / 480, 1 / 960)},
    particles=(2,),
)
