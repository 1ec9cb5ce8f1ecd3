"""Strands at even shares of their arc length, so that strands of different particle counts can be compared."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def resample(strands: NDArray[np.floating], places: int) -> Array:
    """(..., particles, 3) -> (..., places, 3): points at even shares of each polyline's own length, both ends included.
    A strand of no length is repeated."""
    points = np.asarray(strands, np.float64)
    sizes = np.linalg.norm(np.diff(points, axis=-2), axis=-1)
    along = np.concatenate([np.zeros((*sizes.shape[:-1], 1)), np.cumsum(sizes, -1)], -1)
    goals = along[..., -1:] * np.linspace(0, 1, places)
    after = (along[..., None, 1:-1] <= goals[..., None]).sum(-1)  # the segment that each goal lies on
    start = np.take_along_axis(along, after, -1)
    size = np.take_along_axis(sizes, after, -1)
    share = np.clip((goals - start) / np.where(size > 0, size, 1.0), 0.0, 1.0)
    a = np.take_along_axis(points, after[..., None], -2)
    b = np.take_along_axis(points, after[..., None] + 1, -2)
    return np.asarray(a + share[..., None] * (b - a))


def apart(a: Array, b: Array, lengths: NDArray[np.floating]) -> dict[str, float]:
    """How far two sets of strands (T, strands, places, 3) are apart, as shares of each strand's length (strands,) in
    metres: ``median`` and ``p95`` over strands of each one's root mean square over places and times; ``rms`` over all,
    and the greatest distance of all, ``max``.

    Where strands meet solids, some fall to this side or to that by the least of differences; such motion has no limit.
    They show in p95 and max, and would drown all others in a mean.
    """
    away = np.linalg.norm(a - b, axis=-1) / np.asarray(lengths, np.float64)[:, None]
    each = np.sqrt(np.mean(away**2, axis=(0, 2)))
    return {
        "median": float(np.median(each)),
        "p95": float(np.percentile(each, 95)),
        "rms": float(np.sqrt(np.mean(away**2))),
        "max": float(away.max()),
    }
