"""Made hair of a human head of radius 1 about the origin, upright, roots first."""

from __future__ import annotations

import numpy as np

from grown_kit import DOWN, Floats, Random, cap, grow, jitter, number, outside, trimmed, unit


def scalp(g: Random) -> tuple[Floats, Floats, Floats]:
    """Roots on a ball or an oval, normals, and its radii; no roots in the face."""
    radii = np.array([1, *g.choice([[1, 1], [1.1, 1.25], [1.05, 1.15]])])
    out = cap(g, number(g) + 60, g.uniform(75, 110))
    out = out[(out[:, 2] < 0.5) | (out[:, 1] > 0.6)]
    return out * radii, unit(out / radii), radii


def long_hair(g: Random) -> Floats:
    roots, normals, radii = scalp(g)
    length = g.uniform(1, 6) * jitter(g, len(roots))
    return outside(grow(g, roots, normals, length, sag=g.uniform(0.85, 1), frizz=0.01), radii)


def curls(g: Random) -> Floats:
    roots, normals, radii = scalp(g)
    length = g.uniform(1, 4) * jitter(g, len(roots))
    return outside(grow(g, roots, normals, length, sag=0.9, curl=g.uniform(0.02, 0.12), frizz=0.02), radii)


def bob(g: Random) -> Floats:
    """Cut at a height, or to a slope."""
    strands, slope = long_hair(g), g.choice([0.0, 0.4])
    low = g.uniform(-1.2, 0)
    return trimmed(strands, lambda p: low + slope * p[:, 2] - p[:, 1])


def ponytail(g: Random) -> Floats:
    roots, normals, radii = scalp(g)
    tie, count = np.array([0, g.uniform(-0.2, 0.6), -1.25]), len(roots)
    along = np.linspace(0, 1, 10)[None, :, None]
    first = outside((1 - along) * roots[:, None] + along * tie + 0.3 * np.sin(np.pi * along) * normals[:, None], radii)
    spread = tie + 0.06 * g.normal(size=(count, 3))
    rest = grow(g, spread, np.array([[0, 0.3, -1.0]]), g.uniform(1, 4) * jitter(g, count), sag=0.95, frizz=0.02)
    return np.concatenate([first, rest[:, 1:]], axis=1)


def gathered(g: Random) -> Floats:
    """Drawn to a knot from all sides, where it ends: at its surface, inside, or all in one place."""
    roots, normals, radii = scalp(g)
    size, out = g.uniform(0.1, 0.3), cap(g, len(roots), 180)
    knot = np.array([0, g.uniform(-0.3, 1), -1]) * 1.3
    ends = unit(roots + 0.3 * normals - knot) if g.random() < 0.6 else out
    ends = knot + size * ends * (1 if g.random() < 0.6 else g.uniform(0, 1, (len(roots), 1)))
    t = np.linspace(0, 1, int(g.integers(6, 24)))[None, :, None]
    lift = np.sin(np.pi * t) * (g.uniform(0.1, 0.6) * normals[:, None] + 0.02 * g.normal(size=(len(roots), 1, 3)))
    return outside((1 - t) * roots[:, None] + t * ends[:, None] + lift, radii)


def buzz(g: Random) -> Floats:
    roots, normals, _ = scalp(g)
    return grow(g, roots, normals, g.uniform(0.02, 0.3) * (1 - g.choice([0, 0.02]) * g.uniform(size=len(roots))))


def spiky(g: Random) -> Floats:
    roots, normals, _ = scalp(g)
    return grow(g, roots, normals, g.uniform(0.2, 1.5) * jitter(g, len(roots)), frizz=0.02)


def beard(g: Random) -> Floats:
    """About the chin, hanging, cut to a curve or not."""
    out = cap(g, number(g), 75) * [1, -1, 1]
    out = out[out[:, 2] > -0.2] * [0.8, 1, 0.9]
    strands = grow(g, out, out, g.uniform(0.1, 3) * jitter(g, len(out)), sag=g.uniform(0.3, 0.9), frizz=0.02)
    return trimmed(strands, lambda p: np.linalg.norm(p, axis=1) - 1.4) if g.random() < 0.5 else strands


def forward(g: Random) -> Floats:
    """Blown or combed to one side, forward or back, level."""
    roots, normals, radii = scalp(g)
    level = unit(np.array([[1, 0.1, 0], [0, 0.1, 1], [0, 0.1, -1]])[int(g.integers(3))])
    return outside(grow(g, roots, normals, g.uniform(1, 4) * jitter(g, len(roots)), sag=0.9, down=level), radii)


def parted(g: Random) -> Floats:
    """To both sides from a parting."""
    roots, normals, radii = scalp(g)
    ways = normals * g.uniform(0.2, 1) + np.sign(roots[:, :1]) * [1, 0, 0]
    return outside(grow(g, roots, ways, g.uniform(1, 4) * jitter(g, len(roots)), sag=0.9, frizz=0.01), radii)


def braids(g: Random) -> Floats:
    """Tied at both sides, and hanging from there."""
    roots, normals, radii = scalp(g)
    ties = np.array([[-1.3, -0.3, 0], [1.3, -0.3, 0]])[(roots[:, 0] > 0).astype(int)] + 0.05 * g.normal(
        size=roots.shape
    )
    along = np.linspace(0, 1, 10)[None, :, None]
    bow = 0.2 * np.sin(np.pi * along) * normals[:, None]
    first = outside((1 - along) * roots[:, None] + along * ties[:, None] + bow, radii)
    rest = grow(g, ties, DOWN[None], g.uniform(1, 4) * jitter(g, len(roots)), sag=0.9, curl=0.05)
    return np.concatenate([first, rest[:, 1:]], axis=1)


def crest(g: Random) -> Floats:
    """Long on top, shaved at the sides."""
    roots, normals, radii = scalp(g)
    length = np.where(roots[:, 1] > 0.5, g.uniform(1, 3), 0.05) * jitter(g, len(roots))
    return outside(grow(g, roots, normals, length, sag=0.8), radii)


HAIR = (long_hair, curls, bob, ponytail, gathered, buzz, spiky, beard, forward, parted, braids, crest)
