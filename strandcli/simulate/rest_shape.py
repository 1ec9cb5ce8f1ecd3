"""Rest bends as `kernels.rod_curl` reads them, in frames that are parallel-transported along each strand."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..groom.record import Groom, frame

Floats = NDArray[np.float64]

COILED = 0.9
"""Distance of a strand's ends, as a share of its length, below which it is a coil."""


def carried(axes: Floats, edges: Floats, bends: Floats, angles: Floats) -> tuple[Floats, Floats]:
    """(strands, 3) a unit vector across each of the ``axes`` that strands are clamped along, and (N, strands, 3) the
    ``bends`` in the frame of the edge before each joint: along that edge and along two directions across it.

    axes (strands, 3), edges and bends (N, strands, 3). Frames are parallel-transported along the ``edges`` and then
    turned about them by ``angles`` (N, strands); that of the clamp is not turned."""
    first = a = frame(axes)[0]
    t, local = axes, np.empty_like(bends)
    for j in range(len(edges)):
        if j > 0:
            e = edges[j - 1]
            a = a - ((a * e).sum(1) / np.maximum(1 + (t * e).sum(1), 1e-6))[:, None] * (t + e)
            a /= np.linalg.norm(a, axis=1, keepdims=True)
            t = e
        angle = (angles[j - 1] if j > 0 else np.zeros(len(axes)))[:, None]
        b = np.cross(t, a)
        ways = (t, a * np.cos(angle) + b * np.sin(angle), b * np.cos(angle) - a * np.sin(angle))
        local[j] = np.stack([(bends[j] * way).sum(1) for way in ways], 1)
    return first, local


def unit_edges(groom: Groom, n: int) -> tuple[list[Floats], bool]:
    """N arrays (strands, 3) of unit vectors from the root on, in the emitter's frame, and whether some had no length.

    Such an edge takes the direction of the one before it, the first that of the strand, since no iteration finds a
    direction from nothing. Where all strands are straight, all edges are the same array."""
    before = groom.directions.astype(np.float64)
    edges, mended = [], False
    for j in range(n):
        edge = groom.edge(j, n)
        lost = np.asarray(~edge.any(axis=1))
        if lost.any():
            edge, mended = np.where(lost[:, None], before, edge), True
        before = before if np.array_equal(edge, before) else edge  # straight strands need no more than one
        edges.append(before)
    return edges, mended


def coiled(edges: list[Floats]) -> bool:
    """Whether any strand of these edges, (strands, 3) each, is a coil."""
    return float(np.linalg.norm(np.mean(edges, axis=0), axis=1).min()) < COILED


def straight(ways: list[Floats]) -> bool:
    """Whether directions, (strands, 3) each, are all the same."""
    return all(a is b or np.abs(b - a).max() <= 1e-6 for a, b in pairwise(ways))
