"""Made grooms of many kinds, roots first, y up, metres: what guesses about files of strands are measured on.

`made(kind, seed)` makes one with its numbers drawn at random: strands, points, lengths, size, and how it stands. Hair
of a head is of a human's size and stands upright; everything else has any size and is turned in any way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import exchange_kit
from grown_kit import DOWN, Floats, Random, cap, grow, jitter, number, plane, trimmed, unit
from hair_kit import HAIR
from strandcli.exchange.edit.transform import AXES, turning
from strandcli.exchange.strands import Strands

UNITS = (1.0, 0.01, 0.001, 0.1, 0.0254)


class Made(NamedTuple):
    """A groom as a file has it, roots first, and what is true of it: its up axis, and metres a unit."""

    strands: Strands
    up: str
    unit: float


def grass(g: Random) -> Floats:
    roots = plane(g, number(g), 1, g.uniform(0.3, 1))
    lean = roots * 0 + [0, 1, 0] + g.uniform(0, 0.4) * g.normal(size=roots.shape)
    return grow(g, roots, lean, g.uniform(0.03, 0.6) * jitter(g, len(roots)), sag=g.uniform(0, 0.5))


def rough_grass(g: Random) -> Floats:
    """Roots are off the plane, and tips are cut to it, or not."""
    strands = grass(g)
    size = float(np.linalg.norm(strands[:, -1] - strands[:, 0], axis=1).mean())
    strands += g.uniform(0.01, 0.5) * size * g.normal(size=(len(strands), 1, 1)) * [0, 1, 0]
    return trimmed(strands, lambda p: p[:, 1] - 0.6 * size) if g.random() < 0.5 else strands


def hill(g: Random) -> Floats:
    """Grass straight up from a dome, or blown aside."""
    out = cap(g, number(g), g.uniform(20, 80))
    up = [g.uniform(-0.5, 0.5), 1, 0] + g.uniform(0, 0.3) * g.normal(size=out.shape)
    return grow(g, out, up, g.uniform(0.05, 1) * jitter(g, len(out)), sag=g.uniform(0, 0.4))


def plane_fur(g: Random) -> Floats:
    """Combed to one side, cut at a height."""
    strands = grow(g, plane(g, number(g)), np.array([[0, 1.0, 0]]), 1.0, sag=g.uniform(0.2, 0.9), down=[1.0, 0.1, 0])  # type: ignore[arg-type]
    high = g.uniform(0.3, 0.9) * strands[:, -1, 1].min()
    return trimmed(strands, lambda p: p[:, 1] - high)


def mohawk(g: Random) -> Floats:
    """On an arc or a part of it, of any width, fanned out."""
    angle, wide = g.uniform(-1, 1, number(g)) * g.uniform(0.3, 1.6), g.choice([0.0, 0.03, 0.1])
    out = np.stack([wide * g.normal(size=angle.size), np.cos(angle), np.sin(angle)], axis=1)
    return grow(g, unit(out), out * [g.uniform(0, 1), 1, 1], g.uniform(0.3, 1.5) * jitter(g, angle.size))


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


def box_fur(g: Random) -> Floats:
    """Of a box, trimmed to a ball or as it is."""
    way = cap(g, number(g), 180)
    side = np.abs(way).argmax(axis=1)
    normal = np.zeros(way.shape)
    normal[np.arange(len(way)), side] = np.sign(way[np.arange(len(way)), side])
    roots = way / np.abs(way).max(axis=1, keepdims=True) * [1, *g.uniform(0.5, 1.5, 2)]
    strands = grow(g, roots, normal + way, g.uniform(0.1, 3) * jitter(g, len(way)))
    size = np.linalg.norm(roots, axis=1).max() * g.uniform(1, 1.5)
    return trimmed(strands, lambda p: np.linalg.norm(p, axis=1) - size) if g.random() < 0.5 else strands


def brush(g: Random) -> Floats:
    """Bristles on a disc, parted, or drawn to a point."""
    roots = cap(g, number(g), 90) * [1, 0, 1]
    ways = roots * g.uniform(-0.5, 0.5) + [0, 1, 0]
    return grow(g, roots, ways, g.uniform(0.5, 4) * jitter(g, len(roots)), frizz=0.02)


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


def lashes(g: Random) -> Floats:
    x = g.uniform(-1, 1, number(g) // 3 + 20)
    roots = np.stack([x, 0.2 * x**2, 0.5 * (1 - x**2)], axis=1) + 0.01 * g.normal(size=(len(x), 3))
    ways = np.stack([0.6 * x, -0.3 + 0 * x, 1 + 0 * x], axis=1)
    return grow(g, roots, ways, 0.6 * jitter(g, len(x)), sag=0.6, down=[0, 1.0, 0.2])  # type: ignore[arg-type]


def star(g: Random) -> Floats:
    """From a point or a small core, even or rough, to all sides; trimmed to a ball or not."""
    out = cap(g, number(g), 180)
    core = g.choice([0.0, 0.05, 0.3]) * (out if g.random() < 0.5 else g.normal(size=out.shape))
    return grow(g, core, out, jitter(g, len(out)), frizz=g.choice([0, 0.03]))


def lining(g: Random) -> Floats:
    """Fur on the inside of a bowl or a ball."""
    out = cap(g, number(g), g.uniform(60, 180))
    return grow(g, out, -out, g.uniform(0.1, 0.7) * jitter(g, len(out)), frizz=g.choice([0, 0.03]))


def soup(g: Random) -> Floats:
    """Random paths, in a ball, a box or anywhere."""
    count = number(g)
    roots = [plane(g, count), g.uniform(-1, 1, (count, 3)), g.normal(size=(count, 3))][int(g.integers(3))]
    return grow(g, roots, g.normal(size=roots.shape), g.uniform(0.1, 3) * jitter(g, count), frizz=g.choice([0, 0.5]))


def draped(g: Random) -> Floats:
    """From a rough ceiling down to a ball that lies below, cut where they meet it."""
    roots = plane(g, number(g), 2, 2)
    roots[:, 1] += 2.5 + g.choice([0.0, 0.1, 0.3]) * g.normal(size=len(roots))
    roots = roots[np.linalg.norm(roots[:, [0, 2]], axis=1) < 0.9]
    strands = grow(g, roots, np.array([DOWN]), 4.0)
    return trimmed(strands, lambda p: np.where(p[:, 1] < 2, 1 - np.linalg.norm(p, axis=1), -1.0))


def combed(g: Random) -> Floats:
    """Along a ball from where it grows to all sides or to one: from a point, a parting, or all over."""
    count = number(g)
    begin, end = cap(g, count, 100), cap(g, count, 100)
    begin = [begin, unit(begin * [0.02, 1, 1]), unit(0.1 * begin + [0, 1, 0])][int(g.integers(3))]
    end = end if g.random() < 0.5 else unit(begin + np.array([g.uniform(0.5, 2), 0.2, 0]))
    t = np.linspace(0, 1, int(g.integers(6, 24)))[:, None]
    return unit((1 - t) * begin[:, None] + t * end[:, None]) * (1 + g.uniform(0.005, 0.15) * np.sin(np.pi * t))


def arm(g: Random) -> Floats:
    """Fur of a round bar, combed along it."""
    turn, along = g.uniform(0, 2 * np.pi, number(g)), np.array([0, 0, 1.0])
    out = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    roots = out + g.uniform(-3, 3, (turn.size, 1)) * along
    return grow(g, roots, out, g.uniform(0.1, 3) * jitter(g, turn.size), sag=g.uniform(0, 0.9), down=along)


def body(g: Random) -> Floats:
    """Fur of an animal, whose body, neck and head are balls, combed back."""
    centres, radii = np.array([[0, 0, 0], [0, 0.2, 1], [0, 0.5, 2], [0, 0.9, 2.8]]), np.array([1, 0.9, 0.7, 0.6])
    i = g.integers(4, size=number(g))
    out = cap(g, len(i), 180)
    roots = centres[i] + radii[i, None] * out
    seen = (np.linalg.norm(roots[:, None] - centres, axis=2) >= radii - 1e-9).all(axis=1)
    back, length = np.array([0, -0.3, -1.0]), g.uniform(0.05, 1) * jitter(g, int(seen.sum()))
    return grow(g, roots[seen], out[seen], length, sag=g.uniform(0.2, 0.8), down=back)


def hood(g: Random) -> Floats:
    """Lining of an oval, trimmed to a ball inside."""
    out = cap(g, number(g), g.uniform(60, 120))
    strands = grow(g, out * [1.3, 1.4, 1.6], -out, 3.0)
    return trimmed(strands, lambda p: 0.8 - np.linalg.norm(p, axis=1))


THINGS = (
    grass, rough_grass, hill, plane_fur, mohawk, line, afro, fur, box_fur, brush, rope,
    lashes, star, lining, hood, soup, draped, combed, arm, body,
)  # fmt: skip
KINDS = {one.__name__: one for one in (*THINGS, *HAIR)}


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
