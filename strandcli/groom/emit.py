"""Strands as an emitter places them (thesis §1): roots, directions, lengths, all straight.

Everything about strand i depends on the seed and on i alone. So the first thousand strands of ten thousand are the
thousand that would have been emitted alone: counts can be changed without the look jumping, level of detail keeps a
prefix, and no thread count can matter. Roots follow the additive recurrence of Roberts (2018, "The Unreasonable
Effectiveness of Quasirandom Sequences", R2), every prefix of which covers the surface evenly; the rest comes from
NumPy's counter-based Philox generator, one stream a quantity.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..scene.model import DiscShape, Emitter, SphereShape
from .record import Groom, frame
from .tie import bind

Moved = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Roots (strands, 3) in metres, on a sphere about the origin, to where they are moved on it."""
PLASTIC = 1.3247179572447460260  # the real root of x³ = x + 1


def stream(seed: int, number: int, count: int) -> NDArray[np.float64]:
    """(count,) even numbers in [0, 1), of which every shorter request is a prefix."""
    return np.random.Generator(np.random.Philox(key=(seed, number))).random(count)


def emit(emitter: Emitter, seed: int, strands: int | None = None, fringe: Moved | None = None) -> Groom:
    """The first ``strands`` strands of an emitter (all of them by default); ``fringe`` moves some of the roots."""
    count = emitter.strands if strands is None else min(strands, emitter.strands)
    start = stream(seed, 1, 2)
    index = np.arange(count, dtype=np.float64)
    u = (start[0] + index / PLASTIC) % 1.0
    v = (start[1] + index / PLASTIC**2) % 1.0
    roots, normals = _surface(emitter, u, v, seed)
    if fringe is not None:
        roots = fringe(roots)
        normals = roots / np.linalg.norm(roots, axis=1)[:, None]
    grown = None
    if emitter.tie is not None:
        grown = roots
        roots, directions = bind(emitter, grown)
    elif emitter.direction is None:
        directions = normals
    else:
        given = np.array(emitter.direction, np.float64)
        directions = np.broadcast_to(given / np.linalg.norm(given), normals.shape)
    if emitter.comb is not None:
        directions = _combed(emitter, roots, normals)
    if emitter.jitter > 0:
        directions = _tilt(directions, np.radians(emitter.jitter), stream(seed, 2, count), stream(seed, 3, count))
    spread = emitter.length_variation * (2.0 * stream(seed, 4, count) - 1.0)
    # a strand of no length at all has no direction: the shortest keeps a millionth
    lengths = emitter.length * np.maximum(1.0 + spread, 1e-6)
    return Groom(
        roots.astype(np.float32),
        directions.astype(np.float32),
        lengths.astype(np.float32),
        (2.0 * stream(seed, 5, count) - 1.0).astype(np.float32),
        (float(np.radians(emitter.curl_angle)), emitter.curl_turns) if emitter.curl_turns > 0 else (0.0, 0.0),
        grown=grown,
    )


def _surface(
    emitter: Emitter, u: NDArray[np.float64], v: NDArray[np.float64], seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points spread by area and the normals there, both (strands, 3)."""
    shape = emitter.shape
    if isinstance(shape, SphereShape):
        y = 1.0 - u * (1.0 - np.cos(np.radians(rim(shape, v, seed))))
        ring = np.sqrt(np.maximum(1.0 - y * y, 0.0))
        normals = np.stack([ring * np.cos(2 * np.pi * v), y, ring * np.sin(2 * np.pi * v)], 1)
        return shape.radius * normals, normals
    up = np.zeros((len(u), 3))
    up[:, 1] = 1.0
    if isinstance(shape, DiscShape):
        r = shape.radius * np.sqrt(u)
        return np.stack([r * np.cos(2 * np.pi * v), 0 * u, r * np.sin(2 * np.pi * v)], 1), up
    return np.stack([(u - 0.5) * shape.width, 0 * u, (v - 0.5) * shape.depth], 1), up


def rim(shape: SphereShape, v: NDArray[np.float64], seed: int) -> NDArray[np.float64] | float:
    """Polar angle in degrees that each strand's meridian, at the share v of a turn, has its roots down to: the cap's
    less up to `ragged`, half of it by waves along the rim and half at random, so that the rim thins out."""
    if shape.ragged == 0:
        return shape.cap
    waves = np.array([3, 5, 8, 13, 21])
    turns = np.outer(v, waves) + stream(seed, 7, len(waves))
    height = np.sin(2 * np.pi * turns) @ waves**-0.5 / (waves**-0.5).sum()
    less = 0.5 * (0.5 + 0.5 * height) + 0.5 * stream(seed, 8, len(v)) ** 2
    return np.asarray(np.maximum(shape.cap - shape.ragged * less, 1e-3))


SLANT = 0.2
"""Sine of the angle between comb and normal under which combed strands stand up, so that they turn smoothly there."""


def _combed(emitter: Emitter, roots: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Directions along the surface toward the comb's, mirrored to the left of the parting, and lifted off it."""
    comb = np.array(emitter.comb, np.float64)
    way = np.repeat((comb / np.linalg.norm(comb))[None], len(roots), 0)
    way[:, 0] *= sides(emitter, roots)
    way -= (way * normals).sum(1)[:, None] * normals
    way /= np.maximum(np.linalg.norm(way, axis=1), SLANT)[:, None]
    lift = np.radians(emitter.lift)
    found = np.cos(lift) * way + (np.sin(lift) + 1e-3) * normals
    return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])


def sides(emitter: Emitter, roots: NDArray[np.floating]) -> NDArray[np.float64]:
    """Of each root, on which side of the parting it is: −1 to the left, 1 to the right, and in between about and behind
    the middle, where partings end; 1 everywhere without one."""
    if emitter.parting is None:
        return np.ones(len(roots))
    front = np.clip(0.5 + 2.0 * roots[:, 2] / max(float(np.abs(roots).max()), 1e-30), 0.0, 1.0)
    return np.where(roots[:, 0] < emitter.parting, -1.0, 1.0) * front * front * (3.0 - 2.0 * front)


def _tilt(
    axes: NDArray[np.float64], cone: float, u: NDArray[np.float64], v: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Directions spread evenly by solid angle in a cone about each axis, (strands, 3)."""
    first, second = frame(axes)
    cosine = 1.0 - u * (1.0 - np.cos(cone))
    sine = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
    angle = 2 * np.pi * v
    out = cosine[:, None] * axes + (sine * np.cos(angle))[:, None] * first + (sine * np.sin(angle))[:, None] * second
    return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))
