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

from .base import Array, Case, Errors, G, Interval, Reference, Track, groom, interval, off, preset

NODES = 128
NEWTON = 8
"""Iterations at each load."""
METRE = 10.0
"""The load of a level strand of one metre; it grows with the cube of the length."""
LOADS = (0.1, 1.0, 3.0, 10.0, 30.0, 100.0)
"""Γ of the level strands."""
LENGTHS = np.cbrt(np.array(LOADS) / METRE)


@dataclass(frozen=True)
class Shape:
    """A rod at rest, of length 1."""

    nodes: Interval
    """In t, from tip to root."""
    angles: Array
    """(n,) φ at the nodes."""

    def points(self, shares: Array) -> Array:
        """(m, 2): how far out from the clamp and how far down the rod is at shares (m,) of its length from the root."""
        way = np.stack([np.sin(self.angles), np.cos(self.angles)], 1)
        return np.asarray(self.nodes.weights @ way - self.nodes.running(way, 1 - np.asarray(shares, float)))

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
    space = interval(nodes)
    twice = space.above @ space.below
    angles = np.full(nodes, np.pi / 2)
    for load in (*2.0 ** np.arange(np.ceil(np.log2(gamma))), gamma):
        pull = load * space.nodes
        for _ in range(NEWTON):
            residual = angles - np.pi / 2 + twice @ (pull * np.sin(angles))
            angles = angles - np.linalg.solve(np.eye(nodes) + twice * (pull * np.cos(angles)), residual)
    return Shape(space, angles)


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
