"""How fast strands swing, and how short steps are for that."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .kernels.begin import BLEND
from .material import matter_along
from .surroundings import gravity

if TYPE_CHECKING:
    from ...scene.model import Scene
    from .setup import Shape

Floats = NDArray[np.float64]

LOSS = 0.028
"""Share of its amplitude that a strand's slowest swing may lose in a cycle, beyond what drag and damping take."""
FRAMES = 3
"""Frames that the film shows of a cycle at the least; of faster swings it shows none, and steps are no shorter."""
MOST_PARTS = 5
"""Parts that a step is cut into at the most: as many as a swing of `FRAMES` frames takes."""
STRAGGLERS = 0.05
"""Share of the length of all strands whose swings may lose more: the fastest."""
SEGMENTS = 24
"""Segments from which on frequencies hardly depend on their number."""
RATIOS = 1e-4, 1e8
"""Of κ to g / ℓ, between which frequencies depend on both."""
STANDS = 1.05
"""Square of the bending frequency over what weight adds to it above which a strand stays upright."""
SHORTEST_SPAN = 0.2
"""Distance between the ends of a curled strand over its length, at the least: ends that meet say nothing of a swing."""


def longest_turn(loss: Floats) -> Floats:
    """Return the greatest ω Δt at which a cycle takes no more than each ``loss`` of its amplitude; infinity where none
    up to `FRAMES` frames does. A step of BDF2 takes (1 − θ) / 4 (ω Δt)⁴, a long one less (by a fit, to 7 % of it)."""
    turns = np.linspace(0.02, 2 * math.pi / FRAMES, 200)
    lost = -np.expm1(-math.pi / 2 * (1 - BLEND) * turns**3 / (1 + turns**2 / 2))
    return np.interp(loss, lost, turns, right=np.inf)


def slowest(mass: Floats, joint: Floats, ratios: Floats) -> tuple[float, Floats]:
    """Return the squares of the slowest frequencies of small swings of a hanging strand with N masses and joints, (N,)
    each as in `material.matter_along`: of one that weighs nothing, over the κ of a joint; and by ``ratios`` of κ to
    g / ℓ, over g / ℓ."""
    root = 1 / np.sqrt(mass)
    edges = np.eye(len(mass)) - np.eye(len(mass), k=-1)
    bends = edges @ edges
    pull = np.cumsum(mass[::-1])[::-1]
    stiff, heavy = (
        root[:, None] * (forms.T @ (weights[:, None] * forms)) * root
        for forms, weights in ((bends, joint), (edges, pull))
    )
    least = np.linalg.eigvalsh(np.stack([stiff, *(ratio * stiff + heavy for ratio in ratios)]))[:, 0]
    return max(float(least[0]), 0.0), least[1:]


def frequencies(scene: Scene, lengths: Floats, stiffness: Floats, shape: Shape, turn: Floats) -> tuple[Floats, Floats]:
    """Return (strands,) the squares of angular frequencies at which strands swing most slowly, 1/s², and what they
    would be without weight. ``lengths`` of segments and ``stiffness`` are as in `setup.Matter`, ``turn`` (3, 3) is
    the emitter's. A curled strand swings as one as long as its ends are apart, as heavy as it is, and as much softer
    as it has more length to bend."""
    rod, count = scene.rod, len(shape.edges)
    n = min(count, SEGMENTS)
    mass, joint = matter_along(rod, n)
    if rod.root == "hinged":
        joint[0] = 0.0
    span = np.ones(len(lengths))
    if shape.curled:
        span = np.maximum(np.linalg.norm(sum(shape.edges), axis=1) / count, SHORTEST_SPAN)
    rigid = stiffness * (n / count) ** 4 / span**2
    ratios = np.geomspace(*RATIOS, 60)
    by_bending, by_both = slowest(mass, joint, ratios)
    bending = by_bending * rigid
    pull = gravity(scene)
    weight = float(np.linalg.norm(pull))
    if weight == 0:
        return bending, bending
    rate = weight * n / (count * lengths * span)
    ratio = np.clip(rigid / rate, *RATIOS)
    hanging = rate * np.exp(np.interp(np.log(ratio), np.log(ratios), np.log(by_both)))
    hanging = np.maximum(hanging, bending)  # beyond the ratios
    down = shape.axes @ turn.T @ pull / weight
    stands = bending > STANDS * (hanging - bending)
    return bending + np.where(stands, down, 1.0) * (hanging - bending), bending


def swing_rate(scene: Scene, lengths: Floats, stiffness: Floats, shape: Shape, turn: Floats) -> float:
    """Return what a step is multiplied by to have the number of parts, rounded up, that it is cut into for swings to
    keep their amplitude, 1/s; 0 where none asks for it, and of strands that do not hang from their roots alone.
    Arguments are those of `frequencies`.

    What drag and damping take of a swing needs no short steps: of one that they leave a share k of, steps may take
    `LOSS` / k."""
    rod = scene.rod
    if rod.end != "free":
        return 0.0
    square, bending = frequencies(scene, lengths, stiffness, shape, turn)
    decay = (rod.drag + rod.damping * bending) / 2
    damped = np.sqrt(np.maximum(square - decay**2, 0.0))
    swings = (damped > 0) & (damped <= 2 * math.pi * scene.time.fps / FRAMES)
    left = np.exp(-2 * math.pi * decay / np.where(swings, damped, 1.0))
    turns = longest_turn(LOSS / np.maximum(left, LOSS))
    rates = np.where(swings, np.sqrt(np.maximum(square, 0.0)) / turns, 0.0)
    order = np.argsort(-rates, kind="stable")
    share = np.cumsum(lengths[order]) / lengths.sum()
    return float(rates[order[np.searchsorted(share, STRAGGLERS, side="right")]])


def parts(rate: float, dt: float) -> int:
    """Return how many parts a step of ``dt`` seconds is cut into by a `swing_rate`. One that would take more than
    `MOST_PARTS` is longer than a film's, and is left whole."""
    count = max(1, math.ceil(rate * dt - 1e-6))
    return count if count <= MOST_PARTS else 1
