"""Which strands of a file are simulated, and which of them every strand follows.

Strands are compared by where they grow and how they lie: by their roots and by the direction from there to three places
along them, which counts less (`LIKENESS`). In these twelve dimensions a guide on the other side of a parting is far
away, however near its root.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from ..exchange.kernels.along import resample
from ..exchange.strands import even_offsets
from ..groom.emit import stream
from ..groom.family import shepard
from ..groom.record import Groom
from ..scene.checks import CLOSEST_PARTICLES

Floats = NDArray[np.float64]
Features = NDArray[np.float32]

LIKENESS = 1 / 3
"""What a metre of difference between the directions of two strands counts, in metres between their roots."""
SHORTEST = 0.02
"""Length of a guide over that of the median strand, at least: the edges of stubs are hardly more than rounding."""
PLACES = 3
"""Places along strands, the tip among them, at which their directions are compared."""
PARENTS = 4
"""Guides that a strand follows."""
BATCH = 128 * W
"""Strands that are looked at at once, which bounds what that takes."""
SPREAD = 30
"""Number of the random stream by which strands are spread over level of detail."""


def features_of(groom: Groom) -> Features:
    """(strands, 3 + 3 `PLACES`) metres: what strands that are given point by point are compared by."""
    assert groom.points is not None
    found = np.empty((groom.strands, 3 + 3 * PLACES), np.float32)
    for begin in range(0, groom.strands, BATCH):
        points = picked_points(groom, np.arange(begin, min(begin + BATCH, groom.strands)))
        count, n, _ = points.shape
        directions = np.empty((count, PLACES + 1, 3), np.float32)
        low, share = np.empty(directions.shape[:2], np.int64), np.empty(directions.shape[:2], np.float32)
        resample(even_offsets(count, n), points.reshape(-1, 3), low, share, directions, np.empty(count))
        directions[:, 1:] -= directions[:, :1]
        directions[:, 1:] *= np.float32(LIKENESS)
        found[begin : begin + count] = directions.reshape(count, -1)
    return found


def picked_points(groom: Groom, own: NDArray[np.int64]) -> NDArray[np.float32]:
    """(k, n, 3) metres: the points of the strands ``own`` (k,)."""
    assert groom.points is not None
    wide = groom.points.reshape(*groom.points.shape[:2], 3, W)
    return np.ascontiguousarray(wide[own // W, 1:, :, own % W])


def long_enough(lengths: NDArray[np.float32], particles: int) -> NDArray[np.bool_]:
    """(strands,) which strands of these lengths, metres, can be guides with so many particles."""
    least = max(SHORTEST * float(np.median(lengths)), (particles - 1) * CLOSEST_PARTICLES)
    return np.asarray(lengths >= least)


def chosen(features: Features, order: NDArray[np.int32], count: int, fit: NDArray[np.bool_]) -> NDArray[np.int64]:
    """The strands that are simulated, ascending: of each of ``count`` runs of an ``order`` in which those that are
    alike are neighbours, the one that is nearest to the mean of its run, of those that are ``fit`` (strands,); none
    where no strand of a run is."""
    strands = len(features)
    if count >= strands:
        return np.flatnonzero(fit)
    first = np.linspace(0, strands, count + 1).astype(np.int64)[:-1]
    run = np.repeat(np.arange(count), np.diff(np.append(first, strands)))
    own = features[order].astype(np.float64)
    mean = np.add.reduceat(own, first) / np.bincount(run)[:, None]
    away = np.where(fit[order], ((own - mean[run]) ** 2).sum(1), np.inf)
    best = order[np.lexsort((order, away, run))[first]].astype(np.int64)
    return np.sort(best[fit[best]])


def ranks_of(order: NDArray[np.int32], seed: int) -> NDArray[np.int32]:
    """(strands,) the place of each in an order of which every prefix covers all strands evenly: the bits of its place
    in an ``order`` of neighbours, reversed (van der Corput 1935)."""
    strands = len(order)
    bits = max(int(strands - 1).bit_length(), 1)
    place = (np.arange(strands) + int(stream(seed, SPREAD, 1)[0] * strands)) % strands
    key = np.zeros(strands, np.int64)
    for bit in range(bits):
        key |= ((place >> bit) & 1) << (bits - 1 - bit)
    found = np.empty(strands, np.int32)
    found[order[np.argsort(key)]] = np.arange(strands, dtype=np.int32)
    return found


STRAIGHT = 1e-20
"""Square of how far the strand lies beside a chord, over that of a segment, from which on it has a side."""


def chains(points: NDArray[np.float32], particles: int) -> tuple[Floats, Floats]:
    """Chains (G, particles, 3) on strands (G, n, 3), and (G,) the greatest distance of a point from its chain.

    Points at equal distances s along a strand are at most s apart, and less where it bends: a chain through all of
    them is too short. So every other one is a joint, and what lies between two becomes an isosceles triangle with sides
    s on the side on which the strand lies; or, once at the tip, a trapezoid, where the number of segments is odd. Both
    exist whatever the strand is like, for an arc is no shorter than its chord.

    Joint k of a chain stands for the point at k / (particles - 1) of its strand's length. A chain of one segment is the
    chord.
    """
    count, n, _ = points.shape
    joints, last = np.empty((count, particles, 3)), particles - 1
    low, share = np.empty(joints.shape[:2], np.int64), np.empty(joints.shape[:2], np.float32)
    resample(even_offsets(count, n), points.reshape(-1, 3), low, share, joints, np.empty(count))
    passed = np.zeros((count, n))
    np.cumsum(_sizes(np.diff(points.astype(np.float64), axis=1)), axis=1, out=passed[:, 1:])
    total, k = passed[:, -1:], 0
    while last - k > 1:
        end = last if last - k == 3 else k + 2
        _fold(joints[:, k : end + 1], total / last)
        k = end
    place = np.minimum(np.divide(passed, total, out=np.zeros_like(passed), where=total > 0) * last, last - 1)
    rows = place.astype(np.int64)[..., None]
    begins, ends = (np.take_along_axis(joints, rows + step, axis=1) for step in (0, 1))
    edges, offs = ends - begins, points - begins
    squares = (edges * edges).sum(axis=2)
    along = np.divide((offs * edges).sum(axis=2), squares, out=np.zeros_like(squares), where=squares > 0)
    return joints, _sizes(offs - np.clip(along, 0, 1)[..., None] * edges).max(axis=1)


def _sizes(vectors: Floats) -> Floats:
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def _dot(one: Floats, other: Floats) -> Floats:
    return np.asarray(one[:, 0] * other[:, 0] + one[:, 1] * other[:, 1] + one[:, 2] * other[:, 2])[:, None]


def _fold(joints: Floats, size: Floats) -> None:
    """Place the joints between the first and the last of some (G, 3 or 4, 3), so that all segments have a size (G, 1);
    they are where the strand is, and the chord of those two is no longer than the segments together."""
    begin, end, inner = joints[:, 0], joints[:, -1], joints.shape[1] - 2
    chord = _sizes(end - begin)[:, None]
    unit = np.divide(end - begin, chord, out=np.broadcast_to([0.0, 1.0, 0.0], begin.shape).copy(), where=chord > 0)
    side = sum((joints[:, j] - 0.5 * (begin + end) for j in range(1, inner + 1)), np.zeros_like(begin))
    for _ in range(2):  # once leaves rounding, of which little may be left where the strand is nearly straight
        side = side - _dot(side, unit) * unit
    across = np.cross(unit, np.eye(3)[np.argmin(np.abs(unit), axis=1)])
    side = np.where(_dot(side, side) > STRAIGHT * size * size, side, across)
    side = side * (1 / _sizes(side)[:, None])
    ahead = 0.5 * (chord - (inner - 1) * size)
    aside = np.sqrt(np.maximum(size * size - ahead * ahead, 0))
    for j in range(1, inner + 1):
        joints[:, j] = begin + (ahead + (j - 1) * size) * unit + aside * side


def chained(groom: Groom, own: NDArray[np.int64], particles: int) -> tuple[Groom, Floats]:
    """The strands ``own`` as solvers take them, with so many particles at equal distances along them; and (k,) the
    greatest distance of a point from its chain, metres."""
    joints, deviation = chains(picked_points(groom, own), particles)
    steps = np.diff(joints, axis=1)
    sizes = np.linalg.norm(steps, axis=2)
    directions = steps / np.maximum(sizes, 1e-300)[:, :, None]
    placed = groom.placed(np.arange(groom.strands))[own]
    guides = Groom(
        groom.roots[own],
        directions[:, 0].astype(np.float32),
        sizes.sum(1).astype(np.float32),
        groom.tones[own],
        places=np.argsort(np.argsort(placed)).astype(np.int32),
        edges=directions,
        anchors=None if groom.anchors is None else groom.anchors.of(own),
    )
    return guides, deviation


def parents_of(features: Features, guides: Features) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """(strands, P) the guides that strands follow, and how much; a guide follows itself alone."""
    longest = int(np.argmax(np.ptp(guides, axis=0)))
    turn = [longest, *(c for c in range(guides.shape[1]) if c != longest)]
    parents, weights = shepard(np.ascontiguousarray(features[:, turn]), np.ascontiguousarray(guides[:, turn]), PARENTS)
    narrow = weights.astype(np.float32)
    # a guide without weight has no say at all, not even where it is no number
    return np.where(narrow > 0, parents, parents[:, :1]), narrow
