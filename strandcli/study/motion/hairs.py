"""Hair as it is seen, of runs with any number of guides: single hairs at common roots, and metres in cells."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ...groom.emit import emit
from ...groom.family import parents_of, places_of
from ...scene.model import Scene

Array = NDArray[np.float64]


class Hairs:
    """The first hairs of a scene, as the guides of any scene that differs in their number alone lead them.

    A hair at which a guide grows is that guide. Others follow the three guides nearest to their roots with the weights
    that children have (`groom.family`), without locks and waves, and with their own length: so hairs with the same
    roots can be compared whatever the guides, and the error has both what the guides do otherwise and what lies between
    them.
    """

    def __init__(self, scene: Scene, count: int) -> None:
        """``scene``: one with at least as many guides as there are hairs."""
        self._scene = scene
        self._groom = emit(scene.emitter, scene.seed, count)
        self.lengths = self._groom.lengths.astype(np.float64)
        """(hairs,) metres."""
        self._places = places_of(scene.emitter, self._groom)

    def led_by(self, guides: int, points: Array) -> Array:
        """Return (T, hairs, places, 3): hairs as shares of their lengths from their roots, led by so many guides whose
        ``points`` are (T, guides, places, 3), metres."""
        groom = emit(self._scene.emitter, self._scene.seed, guides)
        ways = (points - points[:, :, :1]) / groom.lengths.astype(np.float64)[:, None, None]
        if guides >= len(self.lengths):
            return np.asarray(ways[:, : len(self.lengths)])
        parents, weights = parents_of(self._places, groom)
        found = np.zeros((len(points), len(self.lengths), *points.shape[2:]))
        for parent, weight in zip(parents.T, weights.T, strict=True):
            found += weight[:, None, None] * ways[:, parent]
        return found


class Ruler:
    """Cells that all runs are measured in: their side, how much of the hair they may hold, and where they are."""

    def __init__(self, cell: float, density: float | None, away: float) -> None:
        """``density``: strands a square metre that are allowed, None where nothing is; ``away``: metres that strands
        may go beyond where they are in the first frame."""
        self.cell, self._away = cell, away
        self._full = None if density is None else density * cell**3
        self._box: tuple[Array, tuple[int, ...]] | None = None

    def metres(self, points: Array, each: Array) -> Array:
        """Return the metres of strands in the cells. ``each`` (strands,): what each counts for. The box is that of the
        first strands that are measured."""
        if self._box is None:
            low, high = points.min((0, 1)) - self._away, points.max((0, 1)) + self._away
            counts = np.ceil((high - low) / self.cell).astype(int) + 2
            self._box = self.cell * np.floor(low / self.cell), tuple(counts.tolist())
        return in_cells(points, each, self.cell, *self._box)

    def too_dense(self, cells: Sequence[Array]) -> float | None:
        """Return the share of the hair that is more than cells may hold, the mean of all frames."""
        if self._full is None:
            return None
        return float(np.mean([np.maximum(one - self._full, 0).sum() / one.sum() for one in cells]))


def in_cells(points: Array, metres: NDArray[np.floating], cell: float, low: Array, counts: tuple[int, ...]) -> Array:
    """Return (cells,) the metres of strands in the cells of a box, by trilinear weights. points (strands, places, 3),
    metres: places at even shares of each; metres (strands,): what each counts for; ``low``: the middle of the first
    cell; ``counts``: cells along x, y and z. What is outside counts for the cells at the edge."""
    places = points.shape[1]
    share = np.ones(places)
    share[[0, -1]] = 0.5
    mass = (np.asarray(metres, np.float64)[:, None] * share / (places - 1)).ravel()
    at = (points.reshape(-1, 3) - low) / cell
    below = np.clip(np.floor(at), 0, np.array(counts) - 2)
    part = np.clip(at - below, 0.0, 1.0)
    first = below.astype(np.int64)
    found = np.zeros(int(np.prod(counts)))
    for corner in product((0, 1), repeat=3):
        weight = np.where(corner, part, 1 - part).prod(1)
        x, y, z = (first + corner).T
        found += np.bincount(x + counts[0] * (y + counts[1] * z), mass * weight, len(found))
    return found


def elsewhere(a: Array, b: Array) -> float:
    """Return the share of all hair that has to go into another cell for one grid (cells,) to become another."""
    return float(np.abs(a / a.sum() - b / b.sum()).sum() / 2)
