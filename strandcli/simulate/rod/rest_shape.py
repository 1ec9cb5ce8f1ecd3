"""Rest bends as `kernels.rest_shape` reads them, in frames that are parallel-transported along each strand."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...groom.record import Groom, frame

Floats = NDArray[np.float64]

COILED = 0.9
"""Distance between a strand's ends, as a share of its length, below which it counts as a coil."""


def transported(axes: Floats, edges: Floats, bends: Floats, angles: Floats) -> tuple[Floats, Floats]:
    """Return a unit vector perpendicular to each of the clamped directions ``axes``, (strands, 3), and ``bends``
    (N, strands, 3) in the frame of the edge before each joint: along that edge and along two normals.

    axes (strands, 3), edges and bends (N, strands, 3). Frames are parallel-transported along the edges and then turned
    around them by ``angles`` (N, strands); that of the clamp is not turned."""
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
    """Return N arrays (strands, 3) of unit vectors of edges, root to tip, in the emitter's frame, and whether some had
    no length.

    An edge without length gets the direction of the one before it, the first that of the strand. If all strands are
    straight, all edges are the same array."""
    before = groom.directions.astype(np.float64)
    edges, mended = [], False
    for j in range(n):
        edge = groom.edge(j, n)
        lost = np.asarray(~edge.any(axis=1))
        if lost.any():
            edge, mended = np.where(lost[:, None], before, edge), True
        before = before if np.array_equal(edge, before) else edge  # straight strands share one array
        edges.append(before)
    return edges, mended


def coiled(edges: list[Floats]) -> bool:
    """Return whether any strand with these edges, (strands, 3) each, is a coil."""
    return float(np.linalg.norm(np.mean(edges, axis=0), axis=1).min()) < COILED


def straight(ways: list[Floats]) -> bool:
    """Return whether all directions, (strands, 3) each, are equal."""
    return all(a is b or np.abs(b - a).max() <= 1e-6 for a, b in pairwise(ways))
