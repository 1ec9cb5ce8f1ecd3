"""The planar elastica: level rods that sag under their own weight.

With t the share of arc length from the free tip and φ the tangent's angle from straight down, moments balance where

    φ″ = Γ t sin φ,   φ′(0) = 0,   φ(1) = π / 2,

Γ = ρ A g L³ / B weighing the rod against its bending rigidity B. Integrated twice this is
φ = π / 2 − ∫_t^1 ∫_0^τ Γ σ sin φ dσ dτ, which Newton's method solves at collocation nodes, following the branch that
begins at no load. Strands of one material and of several lengths are several loads in a single run.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre

from .base import Array, Case, Errors, G, Reference, Track, groom, off, preset

NODES = 128
NEWTON = 8
"""Iterations at each load."""
METRE = 10.0
"""The load of a level strand of one metre; it grows with the cube of the length."""
LOADS = (0.1, 1.0, 3.0, 10.0, 30.0, 100.0)
"""Γ of the level strands."""
LENGTHS = np.cbrt(np.array(LOADS) / METRE)


@cache
def collocation(n: int) -> tuple[Array, Array, Array]:
    """n nodes of [0, 1] (Gauss and Legendre), their weights, and what makes of values there (n, ...) the Legendre
    coefficients (n + 1, ...) of the integral from 0 of the polynomial through them."""
    x, weights = legendre.leggauss(n)
    return (x + 1) / 2, weights / 2, legendre.legint(np.linalg.inv(legendre.legvander(x, n - 1)), lbnd=-1) / 2


@dataclass(frozen=True)
class Shape:
    """A rod at rest, of length 1."""

    angles: Array
    """(n,) φ at the nodes, from tip to root."""

    def points(self, shares: Array) -> Array:
        """(m, 2): how far out from the clamp and how far down the rod is at shares (m,) of its length from the root."""
        _, weights, integral = collocation(len(self.angles))
        tangents = np.stack([np.sin(self.angles), np.cos(self.angles)], 1)
        beyond = legendre.legvander(1 - 2 * np.asarray(shares, float), len(self.angles)) @ (integral @ tangents)
        return np.asarray(weights @ tangents - beyond)

    @property
    def tip(self) -> tuple[float, float]:
        """How far out and how far down the tip is."""
        out, down = self.points(np.ones(1))[0]
        return float(out), float(down)

    @property
    def droop(self) -> float:
        """H / W of the literature: how far down over how far out."""
        out, down = self.tip
        return down / out


def hang(gamma: float, nodes: int = NODES) -> Shape:
    """The shape for a weight Γ, on the branch that grows out of the straight rod: the load is doubled up to it."""
    places, weights, integral = collocation(nodes)
    below = legendre.legvander(2 * places - 1, nodes) @ integral
    twice = (weights - below) @ below
    angles = np.full(nodes, np.pi / 2)
    for load in (*2.0 ** np.arange(np.ceil(np.log2(gamma))), gamma):
        pull = load * places
        for _ in range(NEWTON):
            residual = angles - np.pi / 2 + twice @ (pull * np.sin(angles))
            angles = angles - np.linalg.solve(np.eye(nodes) + twice * (pull * np.cos(angles)), residual)
    return Shape(angles)


@cache
def shapes() -> tuple[Shape, ...]:
    """The exact level rods, of length 1."""
    return tuple(hang(load) for load in LOADS)


def case(particles: int) -> Case:
    """Level strands along x, straight at first. The drag lets them come to rest."""
    count = len(LOADS)
    return Case(preset(G / METRE, count, particles, drag=2.0), groom([[1, 0, 0]] * count, LENGTHS))


def measure(track: Track) -> Errors:
    """``tip``: greatest distance of a tip from its exact place, as a share of the length; the error of each H / W."""
    tips = (track.last[:, -1] - track.last[:, 0]) / LENGTHS[:, None]
    goals = np.array([(*shape.tip, 0.0) for shape in shapes()]) * (1, -1, 1)
    droops = {f"H/W Γ={load:g}": off(-tip[1] / tip[0], shape.droop)
              for load, tip, shape in zip(LOADS, tips, shapes(), strict=True)}  # fmt: skip
    return {"tip": float(np.linalg.norm(tips - goals, axis=1).max()), **droops}


ELASTICA = Reference(
    name="elastica", title="heavy elastica: level rods under their own weight, Γ from 0.1 to 100",
    metric="tip", unit="of the length", needs="bending stiffness in physical units",
    span=20.0, case=case, measure=measure,
    exact=lambda: {f"H/W Γ={load:g}": shape.droop for load, shape in zip(LOADS, shapes(), strict=True)},
)  # fmt: skip
