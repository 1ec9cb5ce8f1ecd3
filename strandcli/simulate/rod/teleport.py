"""Roots that move, jump or are free: how to tell, and how to take strands along rigidly."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...groom.record import Groom
from ...scene.motion import Pose
from ..grid.kernels.nodes import move_roots
from .kernels.arrays import PACK, Drive, State

LENGTHS = 2.0
"""Roots that move further than so many strand lengths in one step have been put elsewhere, and not moved."""


class Jumps:
    """Tells whether the roots of a groom jump from one pose of the emitter to the next."""

    def __init__(self, groom: Groom) -> None:
        self._roots = groom.roots
        self._outermost = float(np.linalg.norm(groom.roots, axis=1).max())
        self._reach = LENGTHS * float(groom.lengths.max())

    def between(self, last: Pose, pose: Pose) -> bool:
        """Whether some root moves further than `LENGTHS` of the longest strand."""
        turned = math.hypot(*map(math.dist, pose.rotation, last.rotation))
        if turned * self._outermost + math.dist(pose.translation, last.translation) <= self._reach:
            return False
        turn = np.subtract(pose.rotation, last.rotation)
        moved = self._roots.astype(np.float64) @ turn.T + np.subtract(pose.translation, last.translation)
        return bool(np.sqrt((moved**2).sum(1).max()) > self._reach)


def carry(state: State, positions: NDArray[np.float32], last: Pose, pose: Pose) -> None:
    """Take strands along rigidly from one pose to another, and leave them at rest. ``positions`` are those in single
    precision, which may be the state's own."""
    turn = np.array(pose.rotation) @ np.array(last.rotation).T
    centre, goal = np.array(last.translation), np.array(pose.translation)
    edges = state.edges.reshape(*state.edges.shape[:2], 3, PACK)
    edges[...] = np.einsum("cd,bndk->bnck", turn, edges)
    stop(state.velocity, state.force, state.restart)
    for rows in [positions] if state.positions is positions else [positions, state.positions]:
        wide = rows.reshape(*rows.shape[:2], 3, W).astype(np.float64) - centre[:, None]
        rows[...] = (np.einsum("cd,bndk->bnck", turn, wide) + goal[:, None]).reshape(rows.shape)


def stop(*arrays: NDArray[Any]) -> None:
    """Set arrays to zero."""
    for one in arrays:
        one[...] = 0


def velocity_of_roots(drive: Drive, change: tuple[float, ...], dt: float, out: NDArray[Any]) -> NDArray[Any]:
    """Set ``out`` (P, 3 S) to the velocity of roots in a step of ``dt`` seconds with this ``change`` (12) of the
    emitter's pose, m/s, and return it."""
    kind = drive.roots.dtype
    move_roots(np.array(change, kind), drive.drift, kind.type(dt), drive.roots, out)
    return out


def begin_before_roots(positions: NDArray[np.float32]) -> None:
    """Set the rows before free roots a segment before them."""
    positions[:, 0] = 2 * positions[:, 1] - positions[:, 2]


def turned(turn: NDArray[Any], rows: NDArray[Any]) -> NDArray[Any]:
    """Vectors (packs, 3 `PACK`) turned by a matrix, (packs, 3, `PACK`), in the order of sums that the kernel has."""
    x, y, z = rows.reshape(-1, 3, PACK).transpose(1, 0, 2)
    return np.stack([a * x + b * y + c * z for a, b, c in turn], 1)
