"""Points at which strands that interact are sampled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


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
