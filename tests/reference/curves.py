"""Strands as Bézier curves (thesis §3, corrected), in float64."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def tangents(p: Array, direction: Array, printed: bool = False) -> Array:
    """Unit tangents from root to tip, (strands, n, 3), of particles p (strands, n, 3): the strand's direction at the
    first, zero at the last, and between them the direction of p_{i+1} − p_{i−1}; or, as printed, that of u × (v + w)
    with the sign turned, zero where |u| or |v + w| is under 0.1."""
    out = np.zeros_like(p)
    out[:, 0] = direction
    if printed:
        v, w = p[:, 1:-1] - p[:, :-2], p[:, 1:-1] - p[:, 2:]
        u = np.cross(v, w)
        t = -np.cross(u, v + w)
        bent = (np.linalg.norm(u, axis=2) >= 0.1) & (np.linalg.norm(v + w, axis=2) >= 0.1)
        t = np.where(bent[..., None], t, 0)
    else:
        t = p[:, 2:] - p[:, :-2]
    size = np.linalg.norm(t, axis=2, keepdims=True)
    out[:, 1:-1] = np.divide(t, size, out=np.zeros_like(t), where=size > 0)
    return out


def points(p: Array, direction: Array, length: Array, pieces: int, printed: bool = False) -> Array:
    """(strands, n − 1, pieces + 1, 3): each segment cut evenly; ``length`` (strands,) is that of a segment at rest."""
    t = tangents(p, direction, printed) * length[:, None, None] / 3
    a, b = p[:, :-1, None], p[:, 1:, None]
    c, d = a + t[:, :-1, None], b - t[:, 1:, None]
    s = np.linspace(0, 1, pieces + 1)[:, None]
    return (1 - s) ** 3 * a + 3 * (1 - s) ** 2 * s * c + 3 * (1 - s) * s**2 * d + s**3 * b


def off_the_line(points: Array, line: Array) -> Array:
    """Distance of each point (m, k) from the polyline (v, k)."""
    best = np.full(len(points), np.inf)
    for a, b in pairwise(line):
        way = b - a
        square = way @ way
        share = np.clip((points - a) @ way / square, 0, 1) if square > 0 else np.zeros(len(points))
        best = np.minimum(best, np.linalg.norm(points - a - share[:, None] * way, axis=1))
    return best
