"""Roots that move in the emitter's frame or are hinged: where strands begin, and the frames that carry rest shapes.

A hinge holds neither a direction nor an angle about it. Behind one, frames begin with the first edge as it is before a
step, and so are transported in time (Bergou et al. 2008, "Discrete Elastic Rods", §4.2). Were they transported from the
direction of emission, they would turn the faster about the edge the nearer it came to be opposite to that, which twist
cannot follow.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...constants import FOLD
from .kernels.arrays import PACK
from .setup import packed
from .teleport import turned

if TYPE_CHECKING:
    from ...scene.model import Rod
    from ...scene.motion import Pose
    from .kernels.arrays import Drive, Material, State

TINY = 1e-30


class Roots:
    """Where the roots and directions of `Drive` are, and the normals of `Material.bends`."""

    def __init__(
        self, deforming: Any, strands: int, rod: Rod, arrays: tuple[State, Material, Drive], curled: bool
    ) -> None:
        """``deforming``: how they move in the emitter's frame, or None; ``curled``: whether rest shapes have frames."""
        self._deforming = deforming
        self._state, material, self._drive = arrays
        self._normals = material.bends[:, 0]
        self.hinged = rod.root == "hinged" and curled
        """Whether frames begin with the first edges."""
        self._across: NDArray[Any] | None = None
        """(strands, 3) unit vectors across the clamped directions at the start, where roots and rest shapes turn."""
        if self.hinged:
            material.bends[:, 1] = 0
        elif deforming is not None and curled:
            self._across = self._normals.reshape(-1, 3, PACK).transpose(0, 2, 1).reshape(-1, 3)[:strands].copy()

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
