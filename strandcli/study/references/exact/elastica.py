"""The planar elastica under its own weight and a load at its tip, in double precision: a clamped rod's exact shape.

With t the share of arc length from the free tip and φ the tangent's angle from straight down, moments balance where

    φ″ = (Γ t + α) sin φ,   φ′(0) = 0,   φ(1) = φ_c,

Γ = ρ A g L³ / B weighing the rod against its bending rigidity B, α = P L² / B a load P that hangs on the tip, and φ_c
the clamp's angle: π / 2 is a level clamp, π an upright one. Integrated twice this is φ = φ_c − ∫_t^1 ∫_0^τ (Γ σ + α)
sin φ dσ dτ, which Newton's method solves at collocation nodes, following the branch that begins at no load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....errors import StrandError
from .quadrature import Array, Interval, interval

NODES = 128


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


def hang(gamma: float, load: float = 0.0, clamp: float = np.pi / 2, nodes: int = NODES) -> Shape:
    """The shape for a weight Γ, a tip load α and a clamp φ_c in radians, on the branch that grows out of the straight
    rod. Raises `StrandError` where Newton's method does not get there."""
    space = interval(nodes)
    twice = space.above @ space.below
    pull = gamma * space.nodes + load
    angles = np.full(nodes, float(clamp))
    share, stride = 0.0, 1.0
    while share < 1:
        goal = min(1.0, share + stride)
        found = _newton(angles, twice, goal * pull, clamp)
        if found is None:
            stride /= 2
            if stride < 1e-6:
                raise StrandError(f"elastica: no solution found for gamma {gamma:g}, load {load:g}, clamp {clamp:g}")
            continue
        angles, share, stride = found, goal, 2 * stride
    return Shape(space, angles)


def _newton(angles: Array, twice: Array, pull: Array, clamp: float) -> Array | None:
    """Newton's method from `angles`; None where it leaves the branch, or takes long."""
    start = angles
    for _ in range(12):
        residual = angles - clamp + twice @ (pull * np.sin(angles))
        step = np.linalg.solve(np.eye(len(angles)) + twice * (pull * np.cos(angles)), -residual)
        angles = angles + step
        if np.abs(angles - start).max() > 0.5:
            return None
        if np.abs(step).max() < 1e-12:
            # the branch that grows out of the straight rod is stable as far as it goes: no eigenvalue changes its sign
            stable = np.linalg.slogdet(np.eye(len(angles)) + twice * (pull * np.cos(angles)))[0] > 0
            return angles if stable else None
    return None


def buckling_load(nodes: int = 48) -> float:
    """Γ_c at which an upright rod begins to bow under its own weight: φ = π − ψ with small ψ is an eigenproblem,
    ψ = Γ ∫_t^1 ∫_0^τ σ ψ dσ dτ, whose least Γ is sought (Greenhill 1881)."""
    space = interval(nodes)
    values = np.linalg.eigvals(space.above @ space.below * space.nodes)
    return float(1 / values.real.max())
