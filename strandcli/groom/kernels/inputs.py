"""What the kernels that place children are given: flat tuples of arrays, as kernels can take them.

A: children; C: levels of clumps, from wide to narrow; G: guides; P: guides that each child follows; V: waves; m:
particles of a guide without the row before its root.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Guides(NamedTuple):
    """Strands that children follow, refined."""

    particles: NDArray[np.float32]
    """(G, m + 1, 3) metres; row 0 stands one segment before the root."""
    segments: NDArray[np.float32]
    """(G,) length of a segment, metres."""


class Following(NamedTuple):
    """Where children are rooted, and which guides they follow."""

    parents: NDArray[np.int32]
    """(A, P) guides of each child."""
    weights: NDArray[np.float32]
    """(A, P) how much it follows each; a child's weights add up to 1."""
    roots: NDArray[np.float32]
    """(A, 3) metres."""
    shares: NDArray[np.float32]
    """(A,) a child's length over that of its guides."""


class Clumps(NamedTuple):
    """Locks that children are pulled into."""

    middles: NDArray[np.int32]
    """(C, A) the child in the middle of each one's lock."""
    pulls: NDArray[np.float32]
    """(C, A) part of the distance to that child that is taken away at the tip."""
    ramps: NDArray[np.float32]
    """(C, m) share of the pull along a guide."""


class Waves(NamedTuple):
    """Waves that children wind in."""

    forms: NDArray[np.float32]
    """(V, 2) roundness, from 0 for a flat wave to 1 for a helix, and share of the length over which it sets in."""
    radii: NDArray[np.float32]
    """(V, A) metres, 0 for children that do not wave so."""
    turns: NDArray[np.float32]
    """(V, A) radians a metre."""
    phases: NDArray[np.float32]
    """(V, A) radians at the root."""
    across: NDArray[np.float32]
    """(A, 3) unit vectors at which waves begin."""
