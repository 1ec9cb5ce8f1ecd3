"""Emission of strands (thesis §1): roots, directions and lengths.

Strand i depends on the seed and on i alone. So the first thousand strands of ten thousand are those that would be
emitted alone: the count can change without a change of the look, level of detail draws a prefix, and the number of
threads does not matter. Roots follow the additive recurrence of Roberts (2018, "The Unreasonable Effectiveness of
Quasirandom Sequences", R2), every prefix of which covers the surface evenly; other quantities come from NumPy's
counter-based Philox generator, one stream for each.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..scene.model import DiscShape, Emitter, MeshShape, SphereShape
from ..scene.model.emitter import LEAST_LENGTH
from ..scene.specs import SMALLEST
from .record import Bend, Groom, frame
from .tie import bind

PLASTIC = 1.3247179572447460260  # the real root of x³ = x + 1


def stream(seed: int, number: int, count: int) -> NDArray[np.float64]:
    """Return (count,) uniform random numbers in [0, 1); a smaller count gives a prefix of them."""
    return np.random.Generator(np.random.Philox(key=(seed, number))).random(count)


def tones_of(seed: int, strands: int) -> NDArray[np.float32]:
    """From -1 to 1 for each strand (S,)."""
    found = stream(seed, 5, strands)
    found *= 2.0
    found -= 1.0
    return found.astype(np.float32)


def emit(emitter: Emitter, seed: int, strands: int | None = None) -> Groom:
    """Return the first ``strands`` strands of an emitter, by default all."""
    count = emitter.strands if strands is None else min(strands, emitter.strands)
    start = stream(seed, 1, 2)
    index = np.arange(count, dtype=np.float64)
    u = (start[0] + index / PLASTIC) % 1.0
    v = (start[1] + index / PLASTIC**2) % 1.0
    ground = None
    if isinstance(emitter.shape, MeshShape):
        from .on_mesh import ground as ground_of

        ground = ground_of(emitter.shape, float(start[0]), count)
        roots, normals = ground.points, ground.normals
    else:
        roots, normals = _surface(emitter, u, v)
    grown = None
    if emitter.tie is not None:
        grown = roots
        roots, directions = bind(emitter, grown)
    elif emitter.direction is None:
        directions = normals
    else:
        given = np.array(emitter.direction, np.float64)
        directions = np.broadcast_to(given / np.linalg.norm(given), normals.shape)
    combed = None if ground is None else ground.combed
    if emitter.tie is None and (emitter.comb is not None or combed is not None):
        directions = _combed(emitter, roots, normals, combed)
    if emitter.jitter > 0:
        directions = _tilt(directions, np.radians(emitter.jitter), stream(seed, 2, count), stream(seed, 3, count))
    spread = emitter.length_variation * (2.0 * stream(seed, 4, count) - 1.0)
    lengths = emitter.length * np.maximum(1.0 + spread, LEAST_LENGTH)
    if ground is not None:
        lengths = lengths * ground.lengths
    tones = tones_of(seed, count)
    found = None
    if isinstance(emitter.shape, MeshShape) and ground is not None:
        from .on_mesh import coat

        found = coat(emitter.shape, ground.anchors, tones)
    return Groom(
        roots.astype(np.float32),
        directions.astype(np.float32),
        lengths.astype(np.float32),
        tones if found is None else found.tones,
        (float(np.radians(emitter.curl_angle)), emitter.curl_turns) if emitter.curl_turns > 0 else (0.0, 0.0),
        grown=grown,
        anchors=None if ground is None else ground.anchors,
        colours=None if found is None else found.palette,
        shades=1 if found is None else found.shades,
        bend=_bend(emitter, directions, normals),
        phases=None if found is None else tones,
    )


def _surface(
    emitter: Emitter, u: NDArray[np.float64], v: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return points, uniform by area, and their normals, both (strands, 3); u, v: uniform in [0, 1)."""
    shape = emitter.shape
    assert not isinstance(shape, MeshShape)
    if isinstance(shape, SphereShape):
        y = 1.0 - u * (1.0 - np.cos(np.radians(shape.cap)))
        ring = np.sqrt(np.maximum(1.0 - y * y, 0.0))
        normals = np.stack([ring * np.cos(2 * np.pi * v), y, ring * np.sin(2 * np.pi * v)], 1)
        return shape.radius * normals, normals
    up = np.zeros((len(u), 3))
    up[:, 1] = 1.0
    if isinstance(shape, DiscShape):
        r = shape.radius * np.sqrt(u)
        return np.stack([r * np.cos(2 * np.pi * v), 0 * u, r * np.sin(2 * np.pi * v)], 1), up
    return np.stack([(u - 0.5) * shape.width, 0 * u, (v - 0.5) * shape.depth], 1), up


SLANT = 0.2
"""Sine of the angle between comb and normal below which combed strands stand up, so that directions are continuous."""
UNCOMBED = 1e-3
"""Length of a mesh's own direction of combing below which it has none."""


def _combed(
    emitter: Emitter, roots: NDArray[np.float64], normals: NDArray[np.float64], combed: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Return unit directions along the surface toward that of the comb, mirrored left of the parting, and lifted;
    ``combed`` (strands, 3): directions that go before it where they are not 0."""
    comb = np.zeros(3) if emitter.comb is None else np.array(emitter.comb, np.float64)
    along = np.repeat((comb / max(float(np.linalg.norm(comb)), SMALLEST))[None], len(roots), 0)
    along[:, 0] *= sides(emitter, roots)
    if combed is not None:
        size = np.linalg.norm(combed, axis=1)[:, None]
        along = np.where(size > UNCOMBED, combed / np.maximum(size, UNCOMBED), along)
    along -= (along * normals).sum(1)[:, None] * normals
    along /= np.maximum(np.linalg.norm(along, axis=1), SLANT)[:, None]
    lift = np.radians(emitter.lift)
    found = np.cos(lift) * along + (np.sin(lift) + 1e-3) * normals
    return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])


def _bend(emitter: Emitter, directions: NDArray[np.float64], normals: NDArray[np.float64]) -> Bend | None:
    """Return how strands bend toward the surface whose normals are given; None where they are straight."""
    if emitter.bend == 0 or emitter.tie is not None:
        return None
    inward = (directions * normals).sum(1)[:, None] * directions - normals
    size = np.linalg.norm(inward, axis=1)[:, None]
    inward = np.where(size > SMALLEST, inward / np.maximum(size, SMALLEST), frame(directions)[0])
    return Bend(float(np.radians(emitter.bend)), emitter.bend_onset, inward.astype(np.float32))


def sides(emitter: Emitter, roots: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the side of the parting of each root: −1 left, 1 right, between them near and behind the middle, where
    partings end; 1 everywhere without one."""
    if emitter.parting is None:
        return np.ones(len(roots))
    front = np.clip(0.5 + 2.0 * roots[:, 2] / max(float(np.abs(roots).max()), 1e-30), 0.0, 1.0)
    return np.where(roots[:, 0] < emitter.parting, -1.0, 1.0) * front * front * (3.0 - 2.0 * front)


def _tilt(
    axes: NDArray[np.float64], cone: float, u: NDArray[np.float64], v: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return directions, uniform by solid angle in a cone around each axis, (strands, 3); u, v: uniform in [0, 1)."""
    first, second = frame(axes)
    cosine = 1.0 - u * (1.0 - np.cos(cone))
    sine = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
    angle = 2 * np.pi * v
    out = cosine[:, None] * axes + (sine * np.cos(angle))[:, None] * first + (sine * np.sin(angle))[:, None] * second
    return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))
