"""Roots that move in the emitter's frame, jump or are hinged: where strands begin, the frames of their rest shapes, and
how strands are taken along rigidly.

A hinge has neither a direction nor an angle about it. Behind one, frames begin with the first edge as it is before a
step, and so are transported in time (Bergou et al. 2008, "Discrete Elastic Rods", §4.2).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...constants import FOLD, W
from ...groom.record import Groom
from ...scene.motion import Pose
from .kernels.arrays import PACK, Drive, State
from .setup import packed

if TYPE_CHECKING:
    from ...scene.model import Rod
    from .kernels.arrays import Material

TINY = 1e-30
LENGTHS = 2.0
"""Roots that move further than so many strand lengths in one step have been put elsewhere, and not moved."""


class Roots:
    """Where the roots and directions of `Drive` are, and the normals of `Material.bends`."""

    def __init__(
        self, deforming: Any, groom: Groom, rod: Rod, arrays: tuple[State, Material, Drive], curled: bool
    ) -> None:
        """``deforming``: how they move in the emitter's frame, or None; ``curled``: whether rest shapes have frames."""
        self._deforming = deforming
        self._state, material, self._drive = arrays
        self._roots = groom.roots
        self._outermost = float(np.linalg.norm(groom.roots, axis=1).max())
        self._reach = LENGTHS * float(groom.lengths.max())
        self._normals = material.bends[:, 0]
        self.hinged = rod.root == "hinged" and curled
        """Whether frames begin with the first edges."""
        self._across: NDArray[Any] | None = None
        """(strands, 3) unit vectors across the clamped directions at the start, where roots and rest shapes turn."""
        if self.hinged:
            material.bends[:, 1] = 0
        elif deforming is not None and curled:
            self._across = self._normals.reshape(-1, 3, PACK).transpose(0, 2, 1).reshape(-1, 3)[: groom.strands].copy()

    def jump(self, last: Pose, pose: Pose) -> bool:
        """Whether some root moves further than `LENGTHS` of the longest strand from one pose of the emitter to the
        next."""
        turned = math.hypot(*map(math.dist, pose.rotation, last.rotation))
        if turned * self._outermost + math.dist(pose.translation, last.translation) <= self._reach:
            return False
        turn = np.subtract(pose.rotation, last.rotation)
        moved = self._roots.astype(np.float64) @ turn.T + np.subtract(pose.translation, last.translation)
        return bool(np.sqrt((moved**2).sum(1).max()) > self._reach)

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return what lasts from a step to the next."""
        lasting = {"directions": self._drive.directions, "normals": self._normals} if self.hinged else {}
        return {"roots": self._drive.roots, **lasting}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from that."""
        self._drive.roots[...] = state["roots"]
        if self.hinged:
            self._drive.directions[...] = state["directions"]
            self._normals[...] = state["normals"]

    def deform(self, time: float, pose: Pose) -> None:
        """Set the roots in the emitter's frame where they move there, and how far they came since the last step, which
        ended in a ``pose`` of the emitter."""
        if self._deforming is None:
            return
        drive, kind = self._drive, self._drive.roots.dtype
        before = drive.roots.copy()
        roots, directions = self._deforming.at(time)
        if self._across is not None:
            self._normals[...] = packed(np.einsum("nij,nj->ni", self._deforming.turns(time), self._across), kind)
        drive.roots[...] = packed(roots, kind)
        if not self.hinged:
            drive.directions[...] = packed(directions, kind)
        past = np.array(pose.rotation, kind)
        drive.drift[...] = turned(past, drive.roots - before).reshape(drive.drift.shape)

    def begin_frames(self, last: Pose, pose: Pose) -> None:
        """Have the frames of hinged strands begin with the first edges, for a step from the ``last`` pose of the
        emitter to the next ``pose``."""
        if not self.hinged:
            return
        directions, twist, kind = self._drive.directions, self._state.twist, self._normals.dtype
        turn, back = np.array(last.rotation, kind), np.array(pose.rotation, kind).T
        t, a = turned(turn, directions), turned(turn, self._normals)
        e = self._state.edges[:, 0].reshape(-1, 3, PACK)
        a = a - _dot(a, e) / np.maximum(1 + _dot(t, e), kind.type(FOLD)) * (t + e)
        angle = twist[:, :1].copy()
        a = a * np.cos(angle) + np.cross(e, a, axis=1) * np.sin(angle)
        a -= _dot(a, e) * e
        a /= np.maximum(np.sqrt(_dot(a, a)), kind.type(TINY))
        directions[...], self._normals[...] = (turned(back, one).reshape(directions.shape) for one in (e, a))
        twist -= angle


def _dot(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """Products of vectors (P, 3, S): (P, 1, S)."""
    return np.asarray((a * b).sum(1, keepdims=True))


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


def velocity_of_roots(drive: Drive, turn: tuple[float, ...], shift: tuple[float, ...], dt: float) -> NDArray[Any]:
    """Return (P, 3 S) the velocity of roots, m/s, in a step of ``dt`` seconds in which the emitter's rotation changes
    by ``turn`` (9), and its place by ``shift`` (3)."""
    kind = drive.roots.dtype
    moved = turned(np.array(turn, kind).reshape(3, 3), drive.roots) + np.array(shift, kind)[:, None]
    moved += drive.drift.reshape(-1, 3, PACK) if len(drive.drift) == len(moved) else 0
    return np.asarray(moved / kind.type(dt)).reshape(drive.roots.shape)


def begin_before_roots(positions: NDArray[np.float32]) -> None:
    """Set the rows before free roots a segment before them."""
    positions[:, 0] = 2 * positions[:, 1] - positions[:, 2]


def turned(turn: NDArray[Any], rows: NDArray[Any]) -> NDArray[Any]:
    """Vectors (packs, 3 `PACK`) turned by a matrix, (packs, 3, `PACK`), in the order of sums that the kernel has."""
    x, y, z = rows.reshape(-1, 3, PACK).transpose(1, 0, 2)
    return np.stack([a * x + b * y + c * z for a, b, c in turn], 1)
