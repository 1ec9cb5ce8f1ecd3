"""What made grooms are put together from: roots, strands that bend and curl, and what trims them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Random = np.random.Generator
DOWN = np.array([0.0, -1.0, 0.0])


def unit(vectors: Floats) -> Floats:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30)


def cap(g: Random, count: int, angle: float) -> Floats:
    """Directions (count, 3) evenly over the cap about y of a half angle in degrees."""
    height, turn = g.uniform(np.cos(np.radians(angle)), 1, count), g.uniform(0, 2 * np.pi, count)
    ring = np.sqrt(1 - height**2)
    return np.stack([ring * np.cos(turn), height, ring * np.sin(turn)], axis=1)


def plane(g: Random, count: int, x: float = 1.0, z: float = 1.0) -> Floats:
    return g.uniform(-0.5, 0.5, (count, 3)) * [x, 0, z]


def grow(
    g: Random, roots: Floats, way: Floats, length: Floats | float, *, sag: float = 0.0, down: Floats = DOWN,
    curl: float = 0.0, frizz: float = 0.0,
) -> Floats:  # fmt: skip
    """Strands (S, n, 3) that leave roots along ``way`` and bend to ``down`` by ``sag``; ``curl``, ``frizz``: radius of
    a helix about them, and size of a random path, lengths."""
    count, points = len(roots), int(g.integers(4, 24))
    t = np.linspace(0, 1, points)[:, None]
    length = np.broadcast_to(length, count)[:, None, None]
    bent = sag * np.minimum(2.5 * t, 1)
    way = np.broadcast_to(unit(way), (count, 3))
    steps = unit((1 - bent) * way[:, None] + bent * down)
    steps[:, 0] = 0
    found = np.cumsum(steps, axis=1) / (points - 1)
    if curl:
        phase = g.uniform(0, 2 * np.pi, (count, 1, 1)) + g.uniform(4, 9) * 2 * t
        found += curl * np.minimum(3 * t, 1) * np.concatenate([np.cos(phase), 0 * phase, np.sin(phase)], axis=2)
    if frizz:
        found += frizz * np.cumsum(g.normal(size=found.shape), axis=1) / np.sqrt(points) * (t > 0)
    return roots[:, None] + length * found


def jitter(g: Random, count: int, low: float = 0.0) -> Floats:
    """Lengths (count,) of a share that is drawn once, the most being 1."""
    return 1 - max(low, g.choice([0.02, 0.1, 0.3, 0.6])) * g.uniform(size=count)


def outside(strands: Floats, radii: Floats | float) -> Floats:
    """Strands whose points inside an ellipsoid about the origin are moved onto it."""
    size = np.linalg.norm(strands / radii, axis=-1, keepdims=True)
    return np.where(size < 1, strands / np.maximum(size, 1e-9), strands)


def trimmed(strands: Floats, off: Callable[[Floats], Floats]) -> Floats:
    """Strands drawn in to where ``off`` their surface changes its sign, those that never reach it as they are."""
    t, low, high = np.linspace(0, 1, strands.shape[1]), np.zeros(len(strands)), np.ones(len(strands))
    for _ in range(40):
        middle = 0.5 * (low + high)
        inside = off(_at(strands, t, middle)) < 0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return np.stack([_at(strands, t, low * one) for one in t], axis=1)


def _at(strands: Floats, t: Floats, place: Floats) -> Floats:
    i = np.minimum((place * (len(t) - 1)).astype(int), len(t) - 2)
    part = (place * (len(t) - 1) - i)[:, None]
    rows = np.arange(len(strands))
    return (1 - part) * strands[rows, i] + part * strands[rows, i + 1]


def number(g: Random) -> int:
    return int(g.integers(60, 500))
