"""What the grid of strands that interact knows of them: the points at which they are sampled, their nodes, what strands
around have done to these, the boxes of cells about them, and the step that it is laid for."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...groom.blocks import on_large_pages
from ...solids import Solids
from ..rod.kernels.arrays import AXES, PACK, State
from .kernels.pressure import HELD
from .kernels.records import FIRST, HANDED, LANES, LOW, NODE, OFFSET, SIZE, Lattice, Moving

MOST_CELLS = 4_000_000
"""Of the box about the strands: some 120 bytes each, 470 MB."""


class GridStrands:
    """The strands of a `StrandGrid`."""

    def __init__(self, samples: Samples, segments: int, metres: NDArray[np.float32], boxes: int, dtype: Any) -> None:
        """``metres``: as `Moving` has them; ``boxes``: how many there are, of all parts and of all."""
        self._samples, self._metres, self._kind = samples, metres, np.dtype(dtype).type
        nodes = nodes_of(samples, segments)
        self._lattice = [one.astype(dtype) if one.dtype.kind == "f" else one for one in nodes]
        self._weights, self._origins = samples.weights.astype(dtype), np.empty((boxes, 3), dtype)
        packs, count = len(metres), len(nodes.node_first)
        self._nodes = on_large_pages((packs, count, NODE * PACK), dtype)
        self.ends = np.empty((packs, 6), dtype)
        """As `Moving` has them."""
        self.others = on_large_pages((packs, count, AXES), dtype)
        """(P, M, 3 S) after a step, of nodes: velocity at its begin, and `1 - HELD` of what strands around have added,
        m/s."""
        self.pushed = on_large_pages((packs, count, AXES), dtype)
        """As `Moving` has it."""
        self.handed = np.zeros((packs, HANDED * PACK), dtype)
        """What strands around have handed to each in this frame so far, as `HANDED` says."""

    def moving(self, state: State, roots: NDArray[Any], mass: NDArray[Any]) -> Moving:
        """Return what kernels take of strands."""
        return Moving(
            state.positions, state.velocity, self._nodes, self.others, self.pushed, state.jolted, self.ends, roots,
            self._metres, mass,
        )  # fmt: skip

    def lattice(self, cell: float, dt: float, before: float) -> Lattice:
        """Return how strands are sampled in a step of ``dt`` seconds after one of ``before``, 0 if there was none;
        origins are to be set."""
        kind, samples = self._kind, self._samples
        steps = kind(dt), kind(dt / before if before else 1.0), kind(1 - HELD)
        sampled = samples.first, samples.counts, self._weights, samples.mass.astype(kind)
        return Lattice._make((*sampled, *self._lattice, kind(1 / cell), self._origins, *steps))

    def shares(self, lattice: Lattice, mass: NDArray[Any]) -> NDArray[Any]:
        """Return (samples, greatest count) the shares of a sample's change that its particles have, 1/s."""
        particles = lattice.first[:, None] + np.arange(-1, lattice.weights.shape[1] - 1)
        each = (lattice.mass / lattice.step)[:, None] * lattice.weights
        return np.asarray(each / mass[np.clip(particles, 0, len(mass) - 1)])


class Samples(NamedTuple):
    """Points at which every strand is sampled, as `Lattice` has them."""

    first: NDArray[np.int64]
    counts: NDArray[np.int64]
    weights: NDArray[np.float64]
    mass: NDArray[np.float64]


class Nodes(NamedTuple):
    """Means of particles that samples are made of, as `Lattice` has them."""

    node_first: NDArray[np.int64]
    node_counts: NDArray[np.int64]
    node_weights: NDArray[np.float64]
    begin: NDArray[np.int64]
    blend: NDArray[np.float64]


def nodes_of(samples: Samples, segments: int) -> Nodes:
    """Return the nodes: samples themselves, where they are of several of so many segments, else particles."""
    count = len(samples.first)
    if count < segments:
        return Nodes(samples.first, samples.counts, samples.weights, np.arange(count), np.ones((count, 1)))
    particles = segments + 1
    each = np.arange(particles), np.ones(particles, np.int64), np.ones((particles, 1))
    return Nodes(*each, samples.first, samples.weights)


def samples_of(segments: NDArray[np.float64], length: float) -> Samples:
    """Return the samples of strands whose segments have the relative masses ``segments`` (N,) and the length
    ``length``, in cells, of the longest. A sample of several segments is a mean by masses."""
    n = len(segments)
    several = max(1, math.ceil(length * (1 - 1e-6)))
    if several > 1:
        t = np.tile((np.arange(several) + 0.5) / several, n)
        first = np.repeat(np.arange(n), several)
        weights, mass = np.stack([1 - t, t], 1), np.repeat(segments / several, several)
        return Samples(first, np.full(len(first), 2), weights, mass)
    group = min(max(1, int(1 / length * (1 + 1e-6))), n)
    first = np.arange(0, n, group)
    count = np.minimum(first + group, n) - first + 1
    weights, mass = np.zeros((len(first), group + 1)), np.zeros(len(first))
    for row, begin, end in zip(range(len(first)), first, first + count - 1, strict=True):
        mass[row] = segments[begin:end].sum()
        weights[row, : end - begin] += segments[begin:end] / 2 / mass[row]
        weights[row, 1 : end - begin + 1] += segments[begin:end] / 2 / mass[row]
    return Samples(first, count, weights, mass)


class Moment(NamedTuple):
    """The step that strands are prepared for."""

    step: float
    """Its length, seconds."""
    wind: tuple[float, float, float]
    """Acceleration of strands at rest by the open wind, m/s²."""
    gravity: tuple[float, float, float]
    """m/s²."""
    solids: Solids | None
    """Those that strands collide with, at its end."""


def extent_of(positions: NDArray[Any]) -> float:
    """Return the greatest extent along an axis of strands in blocks."""
    rows = positions[:, 1:].reshape(len(positions), -1, 3, positions.shape[2] // 3)
    return float((rows.max((0, 1, 3)) - rows.min((0, 1, 3))).max())


def moved(values: NDArray[Any], before: NDArray[np.int64], box: NDArray[np.int64]) -> NDArray[Any]:
    """Return the values of cells in another box, 0 where they had none: (z, y, x)."""
    found = np.zeros(box[SIZE : SIZE + 3][::-1], values.dtype)
    if values.size:
        shift = (box[LOW : LOW + 3] - before[LOW : LOW + 3])[::-1]
        ends = list(zip(shift.tolist(), found.shape, values.shape, strict=True))
        here = tuple(slice(max(-d, 0), max(min(a, b - d), 0)) for d, a, b in ends)
        there = tuple(slice(max(d, 0), max(min(b, a + d), 0)) for d, a, b in ends)
        found[here] = values[there]
    return found


def lay_boxes(
    ends: NDArray[Any], parts: NDArray[np.int64], cell: float, margin: int, where: str, boxes: NDArray[np.int64]
) -> bool:
    """Set the ``boxes`` (parts + 1, `BOX`) about the strands of each part, and ``margin`` cells wider about all. Return
    False where a coordinate is not finite. Raises `UsageError` where they take too many cells.

    ends: as `Moving.ends`; cell: side of a cell, metres; where: the rule, for the message."""
    greatest = np.maximum.reduceat(ends, parts[:, FIRST]).astype(np.float64)
    low, high = np.floor(-greatest[:, :3] / cell - 0.5), np.floor(greatest[:, 3:] / cell - 0.5) + 1
    along = high.max(0) - low.min(0) + 1
    if not np.isfinite(along).all():
        return False
    if (cells := (along + 2 * margin).prod()) > MOST_CELLS:
        factor = 1.0
        while np.prod(np.ceil(along / factor) + 1 + 2 * margin) > MOST_CELLS:  # a flat groom has few across
            factor *= 1.05
        raise UsageError(
            f"{where}.cell: cells of {cell:.3g} m would be {cells:.3g} in the box about the strands, more than "
            f"{MOST_CELLS:,}; make them at least {1.05 * factor * cell:.2g}"
        )
    boxes[:-1, LOW : LOW + 3], boxes[-1, LOW : LOW + 3] = low, low.min(0) - margin
    boxes[:-1, SIZE : SIZE + 3], boxes[-1, SIZE : SIZE + 3] = high - low + 1, along + 2 * margin
    boxes[-1, SIZE] = -(-boxes[-1, SIZE] // LANES) * LANES
    counts = boxes[:-1, SIZE : SIZE + 3].prod(1)
    boxes[:-1, OFFSET] = np.cumsum(counts) - counts
    return True
