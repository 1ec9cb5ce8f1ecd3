"""Strands for contact, and an independent search for where they pass through each other."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from strandcli.groom.record import Groom

Floats = NDArray[np.float64]


def strands(roots: Any, ways: Any, lengths: Any) -> Groom:
    way = np.array(ways, float)
    way /= np.linalg.norm(way, axis=1)[:, None]
    count = len(lengths)
    return Groom(
        np.array(roots, np.float32), way.astype(np.float32), np.array(lengths, np.float32),
        np.zeros(count, np.float32),
    )  # fmt: skip


def crossings(a: Floats, b: Floats) -> int:
    """Segments of different strands that pass through each other on straight ways from ``a`` to ``b``, (S, N + 1, 3):
    where the four ends lie in a plane, the roots of a cubic, the segments must not cross in it."""
    count = 0
    for s in range(len(a)):
        for t in range(s + 1, len(a)):
            for i in range(a.shape[1] - 1):
                for j in range(a.shape[1] - 1):
                    count += crosses(a[s, i : i + 2], b[s, i : i + 2], a[t, j : j + 2], b[t, j : j + 2])
    return count


def crosses(p: Floats, p1: Floats, q: Floats, q1: Floats) -> bool:
    def parts(t: float) -> tuple[Floats, Floats, Floats]:
        x, y = p + t * (p1 - p), q + t * (q1 - q)
        return x[1] - x[0], y[1] - y[0], y[0] - x[0]

    times = np.array([0, 1 / 3, 2 / 3, 1.0])
    volumes = [np.linalg.det(np.stack(parts(t))) for t in times]
    if min(volumes) > 0 or max(volumes) < 0:  # a cubic may still have two roots between: strands that just touch
        return False
    for root in np.roots(np.linalg.solve(np.vander(times, 4), volumes)):
        if abs(root.imag) < 1e-9 and 0 < root.real <= 1:
            e, f, w = parts(root.real)
            places, *_ = np.linalg.lstsq(np.stack([e, -f], 1), w, rcond=None)
            if (places >= 0).all() and (places <= 1).all():
                return True
    return False
