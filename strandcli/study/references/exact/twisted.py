"""A rod that is clamped at both ends, nearer to each other than it is long, and turned at one: Kirchhoff's equations.

With the length and the bending rigidity 1, a tangent t, a force F and a moment M: r' = t, t' = M × t, M' = F × t. So F
and M·t do not change along the rod, and M = M(0) + F × r. Its frame turns by t × t' + (M·t / χ) t. Solved by shooting
for F and M(0), with Runge and Kutta's method, from the planar elastica on by small turns.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
STEPS = 80
"""Of the integration along the rod: errors of 1e-7."""
STEP = 1e-6
"""By which each unknown is changed for a derivative."""
EXACT = 1e-7
"""By how much ends may miss what they are held to."""
TURN = 1.0
"""Radians that the end is turned by from one solution to the next."""


class Twisted(NamedTuple):
    """A rod's form."""

    places: Floats
    """(`STEPS` + 1, 3) evenly along the rod, from the origin along x."""
    twist: float
    """Radians that the frame turns by about the tangent along the rod; the end's turn less that is 2π times the
    writhe."""


def _cross(a: Floats, b: Floats) -> Floats:
    """Vector products of rows; `numpy.cross` takes three times as long."""
    return np.asarray(a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]])


def _slope(state: Floats, force: Floats, moment: Floats, torsion: float) -> Floats:
    """Derivatives of r, t and d, (3, rods, 3)."""
    r, t, d = state
    m = moment + _cross(force, r)
    bend = _cross(m, t)
    turn = _cross(t, bend) + (m * t).sum(1, keepdims=True) / torsion * t
    return np.stack([t, bend, _cross(turn, d)])


def _rods(unknowns: Floats, torsion: float) -> Floats:
    """(`STEPS` + 1, 3, rods, 3) r, t and d along rods of (rods, 6) unknowns."""
    given = unknowns[:, :3], unknowns[:, 3:], torsion
    state, h = np.repeat(np.array([[[0.0, 0, 0]], [[1, 0, 0]], [[0, 1, 0]]]), len(unknowns), 1), 1 / STEPS
    out = [state]
    for _ in range(STEPS):
        a = _slope(state, *given)
        b = _slope(state + h / 2 * a, *given)
        c = _slope(state + h / 2 * b, *given)
        d = _slope(state + h * c, *given)
        state = state + h / 6 * (a + 2 * b + 2 * c + d)
        out.append(state)
    return np.array(out)


def _misses(unknowns: Floats, distance: float, turn: float, torsion: float) -> Floats:
    """(rods, 6) by how much ends miss their places, directions and turns."""
    r, t, d = _rods(unknowns, torsion)[-1]
    angle = np.arctan2(d[:, 2], d[:, 1]) - turn
    angle -= 2 * math.pi * np.round(angle / (2 * math.pi))
    return np.column_stack([r[:, 0] - distance, r[:, 1:], t[:, 1:], angle])


@cache
def solve(distance: float, turn: float, torsion: float) -> Twisted:
    """The form with the ends so far apart, as a share of the length, and the far end turned by radians."""
    bow = 2 * math.sqrt(1 - distance)
    unknowns = np.array([-4 * math.pi**2, 0, 0, 0, 0, 2 * math.pi * bow])
    count = max(1, math.ceil(abs(turn) / TURN))
    for angle in np.linspace(0, turn, count + 1):
        for _ in range(30):
            miss, *moved = _misses(unknowns + STEP * np.eye(7, 6, -1), distance, angle, torsion)
            if np.abs(miss).max() < EXACT:
                break
            # the least change: the rod may be turned about x as a whole
            unknowns = unknowns - np.linalg.lstsq((np.array(moved) - miss).T / STEP, miss, rcond=1e-6)[0]
    return Twisted(_rods(unknowns[None], torsion)[:, 0, 0], float(unknowns[3] / torsion))
