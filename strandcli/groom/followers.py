"""Strands of a file that follow those of them that are simulated.

Children grow about guides and have no shape of their own; these have one, and are carried from where they lie at rest.
A few guides show how hair moves as a whole, and are all that is simulated. `kernels.follow` has the equations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import solids
from ..common.rotations import quaternion_of
from ..constants import W
from ..errors import SimulationError
from ..scene.motion import Pose, emitter_pose
from ..scene.rule_type import touched
from .blocks import lanes, unpack
from .deforming import deforming
from .record import Groom, Widths

if TYPE_CHECKING:
    from ..scene.model import Scene

NOWHERE = Pose(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))
FINER = 4
"""Rows of a guide's table for each of its segments, which stand for equal lengths of its strand."""


@dataclass(frozen=True, eq=False)
class Following:
    """Strands as a file has them, and what they follow. k: those that some frame draws; G: guides; P: guides of each
    strand."""

    groom: Groom
    """Of the k strands; their `places` are those in the file."""
    points: NDArray[np.float32]
    """(k, m, 4) metres in the emitter's frame, what is drawn of them; and how far along its strand each point is, as a
    share of the length."""
    ranks: NDArray[np.int32]
    """(k,) of each strand its place in an order of all of which every prefix covers the groom evenly."""
    parents: NDArray[np.int32]
    """(k, P)"""
    weights: NDArray[np.float32]
    """(k, P), 1 together."""
    reaches: NDArray[np.float32]
    """(k, P) share of each guide's length that the strand follows."""
    guides: Groom


class Followers:
    """The strands of one scene that follow its guides."""

    def __init__(self, scene: Scene, following: Following, rest: NDArray[np.float32]) -> None:
        """``rest``: the guides (blocks, n + 1, 3 W) as the solver has them at first."""
        assert scene.emitter.followers is not None
        self.scene = scene
        self.following = following
        self.groom = following.groom
        self.count = scene.emitter.followers.strands
        """Strands that there are, those too that no frame draws."""
        self.tolerance_px = scene.emitter.followers.tolerance_px
        """Greatest distance of a strand as it is drawn from the file's, on the screen, at rest."""
        self.rest = rest.copy()
        self._carried = any(use.name == "emitter_motion" for use in scene.rules)
        self._pose = emitter_pose(scene.emitter, 0.0)
        self._roots = deforming(scene, following.groom)
        self._guides = None if self._roots is None else deforming(scene, following.guides)

    def select(self, positions: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """The tones of all strands whose guides (blocks, n + 1, 3 W) are finite, and their places in the file. Raises
        `SimulationError` where there are none."""
        places = self.groom.places
        assert places is not None
        if np.isfinite(positions).all():
            return self.groom.tones, places
        rows = positions.reshape(*positions.shape[:2], 3, W)
        good = np.isfinite(rows).all((1, 2)).reshape(-1)
        sound = np.flatnonzero(good[self.following.parents].all(1))
        if not len(sound):
            raise SimulationError("every strand that could be drawn follows one that is lost; mend the preset")
        return self.groom.tones[sound], places[sound]

    def grow(
        self, positions: NDArray[np.float32], lengths: NDArray[np.float32], at: float, ids: NDArray[np.int32],
        scratch: Any,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:  # fmt: skip
        """The strands with places ``ids`` in the file, at a time in seconds, from guides (blocks, n + 1, 3 W):
        positions (blocks, m + 1, 3 W), and the greatest share by which the length of a strand in a block would have
        changed (blocks,). ``lengths`` are what `Children.grow` needs besides."""
        from .kernels import follow as kernel

        part = self._whole if len(ids) == self.groom.strands else self._part(ids)
        rows = (self.rest.shape[1] - 2) * FINER + 1
        table = scratch.borrow("guide_table", (self.following.guides.strands, rows, kernel.COLUMNS), np.float32)
        kernel.motions(positions, self.rest, self._turn(at), table)
        count, points, _ = part.points.shape
        out = scratch.borrow("followers", (-(-count // W), points + 1, 3 * W), np.float32)
        stretch = scratch.borrow("followers_stretch", len(out), np.float32)
        kernel.follow(part, table, solids.pack_all(touched(self.scene), self.scene.emitter, at), out, stretch)
        if self._roots is not None:
            roots = self._roots.roots(at)
            self._shift(out, roots if part is self._whole else roots[self.standing(ids)], at)
        return out, stretch

    def _shift(self, out: NDArray[np.float32], roots: NDArray[np.float64], at: float) -> None:
        """Move strands (blocks, m + 1, 3 W) as a whole to their roots (k, 3), given in the emitter's frame: those of
        guides move otherwise where the mesh between them is stretched."""
        pose = self._now(at)
        wanted = roots @ np.array(pose.rotation).T + np.array(pose.translation)
        shift = wanted - unpack(out[:, 1:2], len(roots))[:, 0]
        out += lanes(shift)[:, None]

    def standing_of(self, ids: NDArray[np.int32] | None) -> tuple[NDArray[np.int32], Widths | None]:
        """Of the strands with places ``ids`` in the file, or of all, their places in the order of level of detail, and
        their widths; None: they are as wide as the material's."""
        ranks, widths = self.following.ranks, self.groom.widths
        if ids is None or len(ids) == self.groom.strands:
            return ranks, widths
        rows = self.standing(ids)
        return ranks[rows], None if widths is None else widths.of(rows)

    def standing(self, ids: NDArray[np.int32]) -> NDArray[np.int64]:
        """Where the strands with these places in the file stand here."""
        found: NDArray[np.int64] = self._standing[ids]
        return found

    @cached_property
    def _standing(self) -> NDArray[np.int64]:
        places = self.groom.places
        assert places is not None
        found = np.zeros(int(places.max()) + 1, np.int64)
        found[places] = np.arange(len(places))
        return found

    def _now(self, at: float) -> Pose:
        return emitter_pose(self.scene.emitter, self.scene.time.pose_time(at) if self._carried else 0.0)

    def _turn(self, at: float) -> NDArray[np.float64]:
        """(G, 4) rotations of guides' roots since the start, unit quaternions: the emitter's, and before it those of
        triangles that deform."""
        now, count = self._now(at), self.following.guides.strands
        outer, start = np.array(now.rotation), np.array(self._pose.rotation).T
        if self._guides is not None:
            return np.array([quaternion_of(outer @ turn @ start) for turn in self._guides.turns(at)])
        if now.rotation == self._pose.rotation:
            return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
        return np.tile(quaternion_of(outer @ start), (count, 1))

    @cached_property
    def _whole(self) -> Any:
        """All strands at rest in the world, as the kernel takes them."""
        from .kernels.follow import Strands

        own = self.following
        return Strands(self._placed(own.points), own.parents, own.weights, own.reaches)

    def _part(self, ids: NDArray[np.int32]) -> Any:
        """The strands with these places in the file."""
        from .kernels.follow import Strands

        rows = self.standing(ids)
        return Strands(*(values[rows] for values in self._whole))

    def _placed(self, points: NDArray[np.float32]) -> NDArray[np.float32]:
        """Points (k, m, 4) in the world, at the start."""
        if self._pose == NOWHERE:
            return points
        turn, shift = np.array(self._pose.rotation), np.array(self._pose.translation)
        out = points.copy()
        for begin in range(0, len(points), W):
            out[begin : begin + W, :, :3] = points[begin : begin + W, :, :3].astype(np.float64) @ turn.T + shift
        return out
