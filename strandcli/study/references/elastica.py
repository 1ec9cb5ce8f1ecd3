"""The planar elastica under its own weight: level rods that sag, and upright ones that buckle.

With t the share of arc length from the free tip and φ the tangent's angle from straight down, moments balance where

    φ″ = Γ t sin φ,   φ′(0) = 0,   φ(1) = φ_c,

Γ = ρ A g L³ / B weighing the rod against its bending rigidity B, and φ_c the clamp's angle: π / 2 is a level clamp, π
an upright one. Integrated twice this is φ = φ_c − ∫_t^1 ∫_0^τ Γ σ sin φ dσ dτ, which Newton's method solves at
collocation nodes, following the branch that begins at no load. Strands of one material and of several lengths are
several loads in a single run.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ...errors import StrandError
from .base import Case, Errors, G, Reference, Track, groom, off, preset
from .collocation import Array, Interval, interval

NODES = 128
METRE = 10.0
"""The load of a level strand of one metre; it grows with the cube of the length."""
LOADS = (0.1, 1.0, 3.0, 10.0, 30.0, 100.0)
"""Γ of the level strands."""
LENGTHS = np.cbrt(np.array(LOADS) / METRE)
TILT = 0.01
"""Of upright strands, off the vertical, radians."""
OUT = 0.35
"""How far out a tip is at the buckling load that is sought, as a share of the length: clearly bowed, soon at rest."""
UPRIGHT_LOADS = np.linspace(6.8, 9.2, 25)
UPRIGHT_LENGTHS = np.cbrt(UPRIGHT_LOADS / 8)


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


def hang(gamma: float, clamp: float = np.pi / 2, nodes: int = NODES) -> Shape:
    """The shape for a weight Γ and a clamp φ_c in radians, on the branch that grows out of the straight rod. Raises
    `StrandError` where Newton's method does not get there."""
    space = interval(nodes)
    twice = space.above @ space.below
    pull = gamma * space.nodes
    angles = np.full(nodes, float(clamp))
    share, stride = 0.0, 1.0
    while share < 1:
        goal = min(1.0, share + stride)
        found = _newton(angles, twice, goal * pull, clamp)
        if found is None:
            stride /= 2
            if stride < 1e-6:
                raise StrandError(f"elastica: no solution found for gamma {gamma:g}, clamp {clamp:g}")
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


@cache
def shapes() -> tuple[Shape, ...]:
    """The exact level rods, of length 1."""
    return tuple(hang(load) for load in LOADS)


def exact() -> dict[str, float]:
    """H / W, how far down the tip is over how far out, for each Γ."""
    return {f"H/W Γ={load:g}": shape.droop for load, shape in zip(LOADS, shapes(), strict=True)}


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


def buckling_load(nodes: int = 48) -> float:
    """Γ_c at which an upright rod begins to bow under its own weight: φ = π − ψ with small ψ is an eigenproblem,
    ψ = Γ ∫_t^1 ∫_0^τ σ ψ dσ dτ, whose least Γ is sought (Greenhill 1881)."""
    space = interval(nodes)
    values = np.linalg.eigvals(space.above @ space.below * space.nodes)
    return float(1 / values.real.max())


@cache
def bowed() -> tuple[float, ...]:
    """How far out the exact tips of upright strands are, as shares of the length."""
    return tuple(hang(load, clamp=np.pi - TILT, nodes=48).tip[0] for load in UPRIGHT_LOADS)


def buckling_exact() -> dict[str, float]:
    """The load of an upright rod, and that of this tilt and push."""
    return {"Γ_c": buckling_load(), f"Γ at {OUT:g} L": _crossing(np.array(bowed())) or 0.0}


def _crossing(out: NDArray[np.float64]) -> float | None:
    """The least load at which the tip is OUT far out, between strands by a line; None where none is, or all are."""
    beyond = np.flatnonzero(out >= OUT)
    if not len(beyond) or beyond[0] == 0 or not np.isfinite(out).all():
        return None
    after = int(beyond[0])
    share = (OUT - out[after - 1]) / (out[after] - out[after - 1])
    return float(UPRIGHT_LOADS[after - 1] + share * (UPRIGHT_LOADS[after] - UPRIGHT_LOADS[after - 1]))


def buckling_case(particles: int) -> Case:
    """Upright strands along y, leaning to x."""
    count = len(UPRIGHT_LOADS)
    way = [[np.sin(TILT), np.cos(TILT), 0.0]] * count
    return Case(preset(G / 8, count, particles, drag=2.0), groom(way, UPRIGHT_LENGTHS))


def measure_buckling(track: Track) -> Errors:
    """``load``: relative error of the buckling load."""
    found = _crossing((track.last[:, -1, 0] - track.last[:, 0, 0]) / UPRIGHT_LENGTHS)
    return {"load": None if found is None else off(found, buckling_exact()[f"Γ at {OUT:g} L"])}


ELASTICA = Reference(
    name="elastica", title="heavy elastica: level rods under their own weight, Γ from 0.1 to 100",
    metric="tip", unit="of the length", needs="bending stiffness in physical units",
    span=20.0, exact=exact, case=case, measure=measure,
)  # fmt: skip
BUCKLING = Reference(
    name="buckling", title="self-buckling of upright rods",
    metric="load", unit="of the load", needs="bending stiffness in physical units",
    span=40.0, exact=buckling_exact, case=buckling_case, measure=measure_buckling,
)  # fmt: skip
