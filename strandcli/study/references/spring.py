"""A helical spring that carries a weight on its axis: it is stretched by twisting the wire (Wahl 1963).

A coil of n turns of a wire of thickness d, D across, has the stiffness k = G d⁴ / (8 n D³) where it is slender, which
is GJ / (2π n R³). Here the wire climbs, so that it bends as well: its part of the displacement is R² s (cos² α / GJ +
sin² α / EI) for a climb α and a length s. An arm of the same wire leads from the coil's end to the axis, where the
weight is, and bends by R³ / (3 EI); what the wire itself weighs is added by quadrature. The coil is clamped along its
tangent.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .base import Case, Errors, G, Reference, Track, groom, off, preset

R, CLIMB, TURNS = 0.05, 0.1, 3.0
"""Radius of the coil, its climb in radii a turn, and its turns, about."""
TORSION = 0.75
"""GJ over EI."""
STRETCH = 0.05
"""Displacement of the end under the weight, over R, of a slender coil."""
MASS = 4.0
"""Of the weight, in masses of the wire."""
ARM = (2, 3, 5)
"""Segments of the arm, which give those of the coil, about 2π to a turn for each."""


def coil(arm: int) -> NDArray[np.float64]:
    """(particles, 3): corners on the helix about −y, then along the arm, all R / arm apart; from the origin."""
    side = R / arm

    def chord(angle: float) -> float:
        return math.hypot(2 * R * math.sin(angle / 2), CLIMB * R * angle / (2 * math.pi))

    low, high = 0.0, math.pi
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if chord(middle) < side else (low, middle)
    angles = low * np.arange(round(2 * math.pi * TURNS / low) + 1)
    helix = R * np.stack([np.cos(angles), -CLIMB * angles / (2 * math.pi), np.sin(angles)], 1)
    inward = (1 - np.arange(1, arm + 1) / arm)[:, None] * helix[-1] * (1, 0, 1) + helix[-1] * (0, 1, 0)
    return np.concatenate([helix, inward]) - helix[0]


def arm_of(particles: int) -> int:
    """The segments of the arm for a number of particles: of `ARM` the nearest."""
    return min(ARM, key=lambda arm: abs(len(coil(arm)) - particles))


def wire(arm: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The wire itself as a fine line: middles (m, 3), tangents (m, 3) and lengths (m,) of its pieces; its coil goes
    through the corners of `coil`."""
    corners = coil(arm)
    end = corners[-arm - 1]
    total = 2 * math.pi * -end[1] / (CLIMB * R)
    m = 4000
    angles = total * (np.arange(m) + 0.5) / m
    middles = R * np.stack([np.cos(angles) - 1, -CLIMB * angles / (2 * math.pi), np.sin(angles)], 1)
    tangents = np.stack([-np.sin(angles), np.full(m, -CLIMB / (2 * math.pi)), np.cos(angles)], 1)
    sizes = np.full(m, R * total / m * math.hypot(1, CLIMB / (2 * math.pi)))
    steps = (np.arange(400) + 0.5) / 400
    middles = np.concatenate([middles, end + steps[:, None] * (corners[-1] - end)])
    inward = (corners[-1] - end) / R
    tangents = np.concatenate([tangents / np.linalg.norm(tangents, axis=1)[:, None], np.tile(inward, (400, 1))])
    return middles, tangents, np.append(sizes, np.full(400, R / 400))


def bending(arm: int) -> float:
    """B / (ρ A) with which a slender coil's end would move by `STRETCH` R under the weight, m⁴/s²."""
    length = float(wire(arm)[2].sum())
    turns = -coil(arm)[-1, 1] / (CLIMB * R)
    return G * MASS * length * 2 * math.pi * turns * R**3 / (TORSION * STRETCH * R)


def displacement(arm: int) -> float:
    """How far down the end comes, metres: the work of the loads' moments along the wire on those of a unit load at the
    end (Castigliano), for small displacements."""
    middles, tangents, sizes = wire(arm)
    rigid = bending(arm)
    end = coil(arm)[-1]
    beyond = np.cumsum(sizes[::-1])[::-1] - sizes / 2
    moment_of = np.cumsum((sizes[:, None] * middles)[::-1], axis=0)[::-1] - sizes[:, None] * middles / 2
    down = np.array([0.0, -1.0, 0.0])
    unit = np.cross(end - middles, down)
    load = G * (MASS * sizes.sum() * unit + np.cross(moment_of - beyond[:, None] * middles, down))
    twisting = (load * tangents).sum(1) * (unit * tangents).sum(1)
    return float((sizes * ((load * unit).sum(1) - twisting + twisting / TORSION)).sum() / rigid)


def case(particles: int) -> Case:
    """One coil at rest, that the weight then stretches."""
    arm = arm_of(particles)
    corners = coil(arm)
    edges = np.diff(corners, axis=0) / (R / arm)
    tangent = np.array([[0.0, -CLIMB / (2 * math.pi), 1.0]])
    made = replace(groom(tangent, [len(edges) * R / arm]), edges=edges[None])
    settings = preset(bending(arm), 1, len(corners), drag=120.0)
    settings["rod"] |= {"rest": "shape", "torsion": TORSION}
    settings["time"]["fps"] = 480
    return Case(settings, made, tip_mass=MASS)


def measure(track: Track) -> Errors:
    """``stiffness``: relative error of weight over displacement."""
    arm = arm_of(track.last.shape[1])
    return {"stiffness": off(displacement(arm), -float(track.last[0, -1, 1] - coil(arm)[-1, 1]))}


SPRING = Reference(
    name="spring", title="a coil that a weight on its axis stretches, G d⁴ / (8 n D³)", metric="stiffness",
    unit="of the stiffness", needs="bending stiffness in physical units, a mass on the tip, twist", span=0.5,
    exact=lambda: {f"stretch, arm of {arm}": displacement(arm) / (STRETCH * R) for arm in ARM},
    case=case, measure=measure, steps=(1 / 480,), particles=tuple(len(coil(arm)) for arm in ARM),
)  # fmt: skip
