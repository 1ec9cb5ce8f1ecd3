"""Inputs of the kernels of children: flat tuples of arrays.

A: children; C: levels of clumps, from wide to narrow; G: guides; P: guides of each child, `PARENTS`; V: waves; m:
particles of a guide.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

PARENTS = 3
"""Guides of a child."""
ROUNDNESS, ONSET = 0, 1
"""Columns of `Waves.forms`."""


class Guides(NamedTuple):
    """Guides, subdivided."""

    offsets: NDArray[np.float32]
    """(G, S) metres from the root, three numbers a point: of the point one segment before the root, and of the m
    particles; then numbers that mean nothing, so that S is a whole number of vectors."""
    segments: NDArray[np.float32]
    """(G,) length of a segment, metres."""


class Following(NamedTuple):
    """Roots of children, and the guides that they follow."""

    parents: NDArray[np.int32]
    """(A, P) numbers of the guides of each child."""
    weights: NDArray[np.float32]
    """(A, P) weights of these guides, whose sum is 1."""
    roots: NDArray[np.float32]
    """(A, 3) metres."""
    shares: NDArray[np.float32]
    """(A,) ratio of a child's length to that of its guides."""


class Clumps(NamedTuple):
    """Clumps of children."""

    centres: NDArray[np.int32]
    """(A, C) which of the ``paths`` is at the centre of each child's clump."""
    pulls: NDArray[np.float32]
    """(A, C) share by which the distance to that child is reduced at the tip."""
    ramps: NDArray[np.float32]
    """(C, S) factor of the pull at each number of a path; 0 up to the root."""
    paths: NDArray[np.float32]
    """(K, S) paths of the children at the centres, along their guides alone: as `Guides.offsets`, from the origin."""


class Waves(NamedTuple):
    """Waves of children."""

    forms: NDArray[np.float32]
    """(V, 2) `ROUNDNESS`, from 0 for a flat wave to 1 for a helix, and `ONSET`, the share of the length over which its
    amplitude grows from 0."""
    radii: NDArray[np.float32]
    """(A, V) amplitude, metres; 0 for children without this wave."""
    turns: NDArray[np.float32]
    """(A, V) radians a metre."""
    phases: NDArray[np.float32]
    """(A, V) radians at the root."""
    across: NDArray[np.float32]
    """(A, 3) unit vectors perpendicular to the root's direction, at which waves begin."""
