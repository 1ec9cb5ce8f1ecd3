"""How far strands of a file stand from each other, which decides how fine opacity maps of them are."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..exchange.strands import Strands
from ..groom.emit import PLASTIC

Floats = NDArray[np.float32]
NEIGHBOURS, PLACES = 8, 32
"""Nearest strands from which the density at a place is estimated, and such places: as when strands are drawn
(`strandcli.draw.geometry.spacing`)."""
SOME, BESIDE, POINTS = 1000, 256, 32
"""Strands among which neighbours are looked for, some that are evenly chosen and all that grow beside it, and points of
each, at most."""
TINY = np.float32(1e-30)


def spacing_of(strands: Strands, order: NDArray[np.integer]) -> float:
    """Metres between neighbouring strands, the median over some of their points; 0 of a single one. ``order`` (S,): in
    which they are drawn, those that grow beside each other together.

    Far from each other, as some of them are, strands seem to stand less densely where they form a sheet; those beside
    one are not its only neighbours where they are tangled. The denser of both counts."""
    count = strands.count
    if count < 2:
        return 0.0
    places = (0.5 + np.arange(PLACES)[:, None] * np.array([1 / PLASTIC, 1 / PLASTIC**2])) % 1.0
    some = np.arange(0, count, -(-count // SOME))
    far, found = _lines(strands, some), []
    for place, along in zip((places[:, 0] * count).astype(np.int64), places[:, 1], strict=True):
        own = order[place]
        begin, end = strands.first[own], strands.first[own + 1]
        point = strands.points[begin + int(along * (end - begin))]
        beside = order[max(place - BESIDE // 2, 0) :][:BESIDE]
        apart = _apart(_lines(strands, beside), point, beside == own)
        found.append(min(apart, _apart(far, point, some == own) * math.sqrt(some.size / count)))
    return float(np.median(found))


def _lines(strands: Strands, numbers: NDArray[np.integer]) -> Floats:
    """(S, n, 3) some points of strands, root and tip among them."""
    counts = strands.first[numbers + 1] - strands.first[numbers]
    along = np.linspace(0.0, 1.0, min(int(counts.max()), POINTS))
    rows = strands.first[numbers][:, None] + np.rint((counts[:, None] - 1) * along).astype(np.int64)
    return strands.points[rows]


def _apart(lines: Floats, point: Floats, own: NDArray[np.bool_]) -> float:
    """Metres between neighbours among lines (S, n, 3) at a point (3,) of one of them, its ``own`` (S,); infinity where
    there is no other."""
    neighbours = min(NEIGHBOURS, int(np.count_nonzero(~own)))
    if neighbours == 0:
        return math.inf
    x, y, z = (lines[:, :, axis] - point[axis] for axis in range(3))
    dx, dy, dz = (np.diff(one, axis=1) for one in (x, y, z))
    x, y, z = x[:, :-1], y[:, :-1], z[:, :-1]
    t = -(x * dx + y * dy + z * dz) / np.maximum(dx * dx + dy * dy + dz * dz, TINY)
    np.clip(t, 0.0, 1.0, out=t)
    least = ((x + t * dx) ** 2 + (y + t * dy) ** 2 + (z + t * dz) ** 2).min(axis=1)
    least[own] = np.inf
    return math.sqrt(math.pi / neighbours * np.partition(least, neighbours - 1)[neighbours - 1])
