"""Made grooms of many kinds, roots first, y up, metres: what guesses about files of strands are measured on.

`made(kind, seed)` makes one with its numbers drawn at random: strands, points, lengths, size, and how it stands. Hair
of a head is of a human's size and stands upright; everything else has any size and is turned in any way.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import exchange_kit
from strandcli.common.rotations import AXES, turning
from strandcli.exchange.strands import Strands

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


def grass(g: Random) -> Floats:
    roots = plane(g, number(g), 1, g.uniform(0.3, 1))
    lean = roots * 0 + [0, 1, 0] + g.uniform(0, 0.4) * g.normal(size=roots.shape)
    return grow(g, roots, lean, g.uniform(0.03, 0.6) * jitter(g, len(roots)), sag=g.uniform(0, 0.5))


def plane_fur(g: Random) -> Floats:
    """Combed to one side, cut at a height."""
    strands = grow(g, plane(g, number(g)), np.array([[0, 1.0, 0]]), 1.0, sag=g.uniform(0.2, 0.9), down=[1.0, 0.1, 0])  # type: ignore[arg-type]
    high = g.uniform(0.3, 0.9) * strands[:, -1, 1].min()
    return trimmed(strands, lambda p: p[:, 1] - high)


def line(g: Random) -> Floats:
    """A fringe, a curtain: from a line or an arc, down to a line or not."""
    x = g.uniform(-1, 1, number(g))
    bow, thick = g.choice([0.0, 0.3, 0.8]), g.choice([0.0, 0.01, 0.1])
    roots = np.stack([x, thick * g.normal(size=x.size), bow * (1 - x**2)], axis=1)
    strands = grow(g, roots, np.array([[0, -0.3, g.uniform(0, 1)]]), 1.5 * jitter(g, x.size), sag=0.9, frizz=0.03)
    low = -g.uniform(0.3, 0.9)
    return trimmed(strands, lambda p: low - p[:, 1]) if g.random() < 0.5 else strands


def afro(g: Random) -> Floats:
    """On a ball or an oval, trimmed to a ball about any place in it; half or all of it."""
    radii = np.array([1, *g.choice([[1, 1], [1.1, 1.25], [0.9, 1.1]])])
    out = cap(g, number(g), g.uniform(60, 180))
    strands = grow(g, out * radii, out, 4.0, curl=0.03, frizz=0.05)
    size, middle = g.uniform(1.35, 2.5), g.uniform(-0.15, 0.15, 3)
    return trimmed(strands, lambda p: np.linalg.norm(p - middle, axis=1) - size)


def fur(g: Random) -> Floats:
    """Of a ball or an oval, combed or not, trimmed as it is or not; on all of it, or a part."""
    radii = np.array([1, *g.choice([[1, 1], [1.1, 1.25], [0.9, 1.1], [1.5, 2]])])
    out = cap(g, number(g), g.uniform(30, 180))
    comb = unit(g.normal(size=3))
    length = g.choice([0.03, 0.1, 0.3, 1.0]) * jitter(g, len(out))
    return grow(g, out * radii, unit(out / radii), length, sag=g.uniform(0, 0.7), down=comb, frizz=0.02)


def rope(g: Random) -> Floats:
    """Twisted about an axis that bends, or three such as a braid; its ends even or frayed."""
    count, t = number(g), np.linspace(0, 1, 40)[None, :, None]
    start, ends = g.uniform(0, 0.3, (2, count, 1, 1)) * g.choice([0.02, 1])
    t = start + (1 - start - ends) * t
    phase = g.uniform(0, 2 * np.pi, (count, 1, 1)) + g.uniform(3, 20) * t
    braid = 2 * np.pi * g.integers(3, size=(count, 1, 1)) / 3 + g.uniform(10, 20) * t
    radius = g.uniform(0, 0.05, (count, 1, 1))
    x = radius * np.cos(phase) + g.choice([0, 0.1]) * np.cos(braid)
    z = radius * np.sin(phase) + g.choice([0, 0.1]) * np.sin(2 * braid)
    return np.concatenate([x + g.uniform(0, 0.5) * t**2, -2 * t, z], axis=2)


def star(g: Random) -> Floats:
    """From a point or a small core, even or rough, to all sides; trimmed to a ball or not."""
    out = cap(g, number(g), 180)
    core = g.choice([0.0, 0.05, 0.3]) * (out if g.random() < 0.5 else g.normal(size=out.shape))
    return grow(g, core, out, jitter(g, len(out)), frizz=g.choice([0, 0.03]))


def combed(g: Random) -> Floats:
    """Along a ball from where it grows to all sides or to one: from a point, a parting, or all over."""
    count = number(g)
    begin, end = cap(g, count, 100), cap(g, count, 100)
    begin = [begin, unit(begin * [0.02, 1, 1]), unit(0.1 * begin + [0, 1, 0])][int(g.integers(3))]
    end = end if g.random() < 0.5 else unit(begin + np.array([g.uniform(0.5, 2), 0.2, 0]))
    t = np.linspace(0, 1, int(g.integers(6, 24)))[:, None]
    return unit((1 - t) * begin[:, None] + t * end[:, None]) * (1 + g.uniform(0.005, 0.15) * np.sin(np.pi * t))


def body(g: Random) -> Floats:
    """Fur of an animal, whose body, neck and head are balls, combed back."""
    centres, radii = np.array([[0, 0, 0], [0, 0.2, 1], [0, 0.5, 2], [0, 0.9, 2.8]]), np.array([1, 0.9, 0.7, 0.6])
    i = g.integers(4, size=number(g))
    out = cap(g, len(i), 180)
    roots = centres[i] + radii[i, None] * out
    seen = (np.linalg.norm(roots[:, None] - centres, axis=2) >= radii - 1e-9).all(axis=1)
    back, length = np.array([0, -0.3, -1.0]), g.uniform(0.05, 1) * jitter(g, int(seen.sum()))
    return grow(g, roots[seen], out[seen], length, sag=g.uniform(0.2, 0.8), down=back)


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


def beard(g: Random) -> Floats:
    """About the chin, hanging, cut to a curve or not."""
    out = cap(g, number(g), 75) * [1, -1, 1]
    out = out[out[:, 2] > -0.2] * [0.8, 1, 0.9]
    strands = grow(g, out, out, g.uniform(0.1, 3) * jitter(g, len(out)), sag=g.uniform(0.3, 0.9), frizz=0.02)
    return trimmed(strands, lambda p: np.linalg.norm(p, axis=1) - 1.4) if g.random() < 0.5 else strands


THINGS = (grass, plane_fur, line, afro, fur, rope, star, combed, body)
HAIR = (long_hair, curls, bob, ponytail, gathered, beard)
KINDS = {one.__name__: one for one in (*THINGS, *HAIR)}
UNITS = (1.0, 0.01, 0.001, 0.1, 0.0254)


class Made(NamedTuple):
    """A groom as a file has it, roots first, and what is true of it: its up axis, and metres a unit."""

    strands: Strands
    up: str
    unit: float


def made(kind: str, seed: int) -> Made:
    g = np.random.default_rng([seed, list(KINDS).index(kind)])
    points = KINDS[kind](g)
    tilt = np.radians(g.uniform(-12, 12, 2))
    size = g.uniform(0.085, 0.115)
    if KINDS[kind] in THINGS:
        tilt = np.radians(g.choice([0, 0, 30, 90, 180]) * g.uniform(-1, 1, 2))
        size = 10 ** g.uniform(-1.5, 1.3)
    yaw = g.uniform(0, 2 * np.pi)
    turn = np.eye(3)
    for angle, one in zip((*tilt, yaw), (0, 2, 1), strict=True):
        a, b = (one + 1) % 3, (one + 2) % 3
        step = np.eye(3)
        step[[a, a, b, b], [a, b, a, b]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
        turn = step @ turn
    up, metres = str(g.choice(AXES)), float(g.choice(UNITS))
    points = size / metres * ((points @ turn.T + g.uniform(-3, 3, 3) * g.choice([0, 1])) @ turning("y", up).T)
    return Made(exchange_kit.of(list(points.astype(np.float32))), up, metres)
