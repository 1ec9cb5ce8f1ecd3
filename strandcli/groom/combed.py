"""Combed parts: paths of tied strands from root to tie, which are not simulated but move with the emitter.

They are computed once, in the emitter's frame; a frame costs a rigid transform and a copy. The result is one line from
root to tip for all later stages.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from ..scene.model import MeshShape
from ..scene.motion import emitter_pose
from .blocks import pack
from .emit import stream
from .record import Groom
from .tie import Floats, Over, chosen, paths, wisps

if TYPE_CHECKING:
    from ..scene.model import Scene

BATCH = 1 << 16
"""Strands that are combed at once, which bounds the memory."""
BOW_POWER = 6
"""Power of a uniform random number that gives a strand's bow: half of them are below a sixtieth of the greatest."""


class Combed:
    """Combed parts of the strands of a scene whose emitter has a tie."""

    def __init__(self, scene: Scene, groom: Groom) -> None:
        """``groom``: all drawn strands, children included."""
        self.scene = scene
        self.groom = groom
        assert scene.emitter.tie is not None
        self.tie = scene.emitter.tie
        self._carried = any(use.name == "emitter_motion" for use in scene.rules)
        self._wisps: NDArray[np.float32] | None = None

    def join(
        self, hanging: NDArray[np.float32], at: float, strands: int, scratch: Any, ids: NDArray[np.int32] | None = None
    ) -> NDArray[np.float32]:
        """Return the first ``strands`` strands, or of those numbered ``ids``, from root to tip at a time in seconds:
        positions (blocks, rows, 3 W); hanging: their parts beyond the tie, in the same layout."""
        from .kernels import surface as kernel

        combed = self.packed if ids is None else pack(self.points[ids[:strands]])
        rotation, shift = emitter_pose(self.scene.emitter, at if self._carried else 0.0)
        blocks = -(-strands // W)
        out = scratch.borrow("combed", (blocks, combed.shape[1] + hanging.shape[1] - 1, 3 * W), np.float32)
        kernel.join(combed, hanging, np.array(rotation, np.float32).ravel(), np.array(shift, np.float32), out)
        if len(self.short):
            own = np.arange(strands) if ids is None else ids[:strands]
            number = np.searchsorted(self.short, own)
            place = np.flatnonzero(self.short[np.minimum(number, len(self.short) - 1)] == own)
            points = self._short(out.shape[1])[number[place]] @ np.array(rotation).T + np.array(shift)
            out.reshape(blocks, -1, 3, W)[place // W, :, :, place % W] = points
        return out

    @cached_property
    def short(self) -> NDArray[np.int64]:
        """(K,) numbers of the strands that are too short for the tie, ascending."""
        groom, emitter = self.groom, self.scene.emitter
        if self.tie.wisps == 0:
            return np.zeros(0, np.int64)
        return chosen(emitter, groom, groom.placed(stream(self.scene.seed, 11, groom.strands)))

    def _short(self, rows: int) -> NDArray[np.float32]:
        """Return those strands, (K, rows, 3) metres in the emitter's frame."""
        if self._wisps is None or self._wisps.shape[1] != rows:
            groom, emitter, seed = self.groom, self.scene.emitter, self.scene.seed
            assert groom.grown is not None
            lots = np.stack([groom.placed(stream(seed, 12 + k, groom.strands))[self.short] for k in range(4)], 1)
            self._wisps = wisps(emitter, groom.grown[self.short], lots, rows, _over(emitter.shape))
        return self._wisps

    @cached_property
    def packed(self) -> NDArray[np.float32]:
        """(blocks, 1 + `TIED`, 3 W) metres in the emitter's frame."""
        return pack(self.points)

    @cached_property
    def points(self) -> NDArray[np.float32]:
        """(strands, 1 + `TIED`, 3) metres in the emitter's frame: the row before the root, then points to the tie."""
        groom, emitter, seed = self.groom, self.scene.emitter, self.scene.seed
        assert groom.grown is not None
        far = self.tie.slack * stream(seed, 9, groom.strands) ** BOW_POWER
        bows = groom.placed(np.stack([far, far * (2.0 * stream(seed, 10, groom.strands) - 1.0)], 1))
        over = _over(emitter.shape)
        found = []
        for begin in range(0, groom.strands, BATCH):
            some = slice(begin, begin + BATCH)
            part = Groom(
                groom.roots[some], groom.directions[some], groom.lengths[some], groom.tones[some],
                grown=groom.grown[some],
            )  # fmt: skip
            found.append(paths(emitter, part, bows[some], over).astype(np.float32))
        return np.concatenate(found)


def _over(shape: Any) -> Over:
    """Return what lifts points out of the mesh that strands grow on; they are on any other shape."""

    def over(points: Floats, normals: Floats) -> Floats:
        if not isinstance(shape, MeshShape):
            return np.zeros(len(points))
        from .on_mesh import rise

        return np.maximum(rise(shape, points, normals), 0.0)

    return over
