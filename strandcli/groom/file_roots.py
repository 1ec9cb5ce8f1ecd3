"""Roots of strands of a file that moves: they stand where it has them, and turn as its strands do there."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .record import Groom

Floats = NDArray[np.float64]
FLAT = 1e-6
"""Of the greatest extent, the second one below which points lie on a line, and tell no turn about it."""
EXACT = 1e-9
"""Frames that a time may be off a frame."""


class FileRoots:
    """The roots of a groom (n strands) whose `film` is the moments of a file and the rows (n,) of its strands there.

    A root turns as all roots and first segments do together, as a rigid body, and then by the least angle into its own
    first segment's direction. Between frames roots and segments move in straight lines.
    """

    def __init__(self, scene: Scene, groom: Groom) -> None:
        """``groom``: as it is at the start."""
        self._time, self._directions = scene.time, groom.directions.astype(np.float64)
        self._film, self._rows = groom.film
        self._start = self._ends(0.0)

    def at(self, time: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return roots (n, 3), metres, and unit directions (n, 3) at a time in seconds, in the emitter's frame."""
        ends = self._ends(time)
        directions = np.einsum("nij,nj->ni", self._turns(ends), self._directions)
        return ends[self._rows, 0].astype(np.float32), directions.astype(np.float32)

    def roots(self, time: float) -> Floats:
        """Return roots (n, 3), metres, at a time in seconds, in the emitter's frame."""
        return self._ends(time)[self._rows, 0]

    def turns(self, time: float) -> Floats:
        """Return the rotations (n, 3, 3) of roots from the start to a time in seconds, in the emitter's frame."""
        return self._turns(self._ends(time))

    def _ends(self, time: float) -> Floats:
        """Return the first two points (S, 2, 3) of all strands at a time in seconds."""
        frame = self._time.pose_time(time) * self._time.fps
        first = math.floor(frame + EXACT)
        found = self._film.ends(first / self._time.fps, self._time.fps)
        if frame - first <= EXACT:
            return np.asarray(found)
        after = self._film.ends((first + 1) / self._time.fps, self._time.fps)
        return np.asarray(found + (frame - first) * (after - found))

    def _turns(self, ends: Floats) -> Floats:
        whole = rigid(self._start.reshape(-1, 3), ends.reshape(-1, 3))
        before, after = (units(one[self._rows, 1] - one[self._rows, 0]) for one in (self._start, ends))
        return least_turns(before @ whole.T, after) @ whole


def rigid(first: Floats, second: Floats) -> Floats:
    """Return the rotation (3, 3) that takes points (k, 3) to others best (Kabsch 1976), none of those on a line."""
    a, b = first - first.mean(axis=0), second - second.mean(axis=0)
    u, extents, v = np.linalg.svd(b.T @ a)
    if extents[1] <= FLAT * extents[0]:
        return np.eye(3)
    mirrored = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))])
    return np.asarray(u @ mirrored @ v)


def least_turns(first: Floats, second: Floats) -> Floats:
    """Return the rotations (n, 3, 3) by the least angles that take unit vectors (n, 3) to others; half a turn about any
    axis across where they are opposite."""
    total = first + second
    back = np.einsum("ni,ni->n", total, total) < EXACT
    x = np.abs(first[:, :1]) < 0.9
    across = units(np.cross(first, np.where(x, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])))
    middle = np.where(back[:, None], across, units(total))
    flip = 2 * np.einsum("ni,nj->nij", middle, middle) - np.eye(3)
    straight = 2 * np.einsum("ni,nj->nij", first, first) - np.eye(3)
    turns = flip @ straight
    return np.asarray(np.where(back[:, None, None], flip, turns))


def units(vectors: Floats) -> Floats:
    """Return unit vectors (n, 3); +y where there is no direction."""
    sizes = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(sizes > 0, vectors / np.where(sizes > 0, sizes, 1.0), np.array([0.0, 1.0, 0.0]))
