"""The strands that are drawn at a moment, from those that are simulated."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..groom.children import Children, Leading
from ..groom.followers import Followers
from ..scene.detail import strands_needed
from .common.scratch import IN_LIGHT, IN_PICTURE, POSITIONS, Scratch
from .geometry.detail import level_of, with_widths
from .geometry.spacing import first_emitted, measured
from .strand_batches import Strands, Whole

if TYPE_CHECKING:
    from ..groom.combed import Combed
    from ..groom.record import Groom
    from ..scene.model import Scene
    from .common.drawing import Drawing
    from .geometry.detail import Level


class DrawnStrands:
    """Children, followers, combed parts and level of detail of one scene."""

    def __init__(
        self, groom: Groom, children: Children | Followers | None, combed: Combed | None, thins: bool, scratch: Scratch,
        every: bool = False,
    ) -> None:  # fmt: skip
        """``groom``: of the strands that are drawn, but for children; ``thins``: strands that fade become thinner, and
        not shorter; ``every``: children that level of detail does not draw are made too."""
        self.children, self.combed, self.thins, self.scratch = children, combed, thins, scratch
        self._chooses = isinstance(children, Children) and combed is None and thins and not every
        self._around = Scratch() if self._chooses else scratch
        self._followers = children if isinstance(children, Followers) else None
        # segments of a strand differ in length
        self.uneven = combed is not None or groom.points is not None or self._followers is not None
        self._widths = groom.widths
        self._near: tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.int64]] | None = None

    def at(
        self, scene: Scene, at: float, positions: NDArray[np.float32], lengths: NDArray[np.float32],
        tones: NDArray[np.float32], ids: NDArray[np.int32] | None, drawing: Drawing,
    ) -> Strands:  # fmt: skip
        """The strands of a scene that are drawn at a time in seconds, from simulated ones (blocks, n + 1, 3 W) with
        segment rest lengths (blocks, W). ``tones`` and ``ids`` (strands,): of those that can be drawn, their tones and
        places in the order of emission, None: 0, 1, …"""
        self.scratch.release(*POSITIONS, *IN_LIGHT, *IN_PICTURE)  # of the exposure before
        if isinstance(self.children, Children):
            assert ids is not None
            shown = ids < max(strands_needed(scene, at), int(ids.min()) + 1)
            if not shown.all():
                tones, ids = tones[shown], ids[shown]
        elif ids is None:  # and so those that level of detail draws are the first
            tones = tones[: strands_needed(scene, at)]
        level = whole = leading = None
        if isinstance(self.children, Children):
            leading = self.children.paths_of(positions, lengths, at, self.scratch)
        if self._chooses and leading is not None and ids is not None:
            level, whole = self._choose(scene, at, leading, ids)
            if whole is not None:
                tones, ids = tones[whole.numbers], ids[whole.numbers]
        count = len(tones)
        places, widths = ids, self._widths
        if self.children is not None:
            assert ids is not None
            if isinstance(self.children, Children) and leading is not None:
                positions, lengths = self.children.grow_along(leading, ids, self.scratch)
            else:
                positions, lengths = self.children.grow(positions, lengths, at, ids, self.scratch)
            if self._followers is not None:
                places, widths = self._followers.standing_of(ids)
                drawing.follow_stretch_max = max(float(lengths.max()), drawing.follow_stretch_max or 0.0)
                drawing.curve_px_max = self._followers.tolerance_px
            drawing.lap("children")
        if self.combed is not None:
            own = None if self.children is None else ids  # without children both stand as the groom does
            positions = self.combed.join(positions, at, count, self.scratch, own)
            self.scratch.release("children")
            drawing.lap("combed")
        if whole is None:
            level = with_widths(level_of(scene, at, positions, count, places, self.thins), widths)
        shares = None if widths is None else widths.shares
        if shares is not None and scene.material.drawn_taper > 0:
            shares = shares * np.linspace(1, 1 - scene.material.drawn_taper, shares.shape[1], dtype=np.float32)
        return Strands(positions, None if self.uneven else lengths, count, level, tones, ids, whole, shares)

    def _choose(
        self, scene: Scene, at: float, leading: Leading, ids: NDArray[np.int32]
    ) -> tuple[Level | None, Whole | None]:  # fmt: skip
        """Return the level of detail of those children of some, by their numbers, that are drawn, and which these are;
        None, None where all are."""
        children = self.children
        assert isinstance(children, Children)
        if scene.detail is None:
            return None, None
        level = level_of(scene, at, children.roots(ids, at), len(ids), ids, self.thins)
        if level is None:
            return None, None
        drawn = np.flatnonzero(level.fade)

        def around() -> tuple[NDArray[np.float32], int, NDArray[np.int64]]:
            some, among = self._near_measured(children, ids)
            grown, _ = children.grow_along(leading, ids[some], self._around)
            return grown, len(some), among

        level = replace(level, fade=level.fade[drawn], scale=level.scale[drawn])
        return level, Whole(len(ids), drawn, around)

    def _near_measured(
        self, children: Children, ids: NDArray[np.int32]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:  # fmt: skip
        """Return which children are made where the distance between strands is measured, and where those on which it is
        are among these. Roots do not move on their surface, so they are found again only for other children."""
        if self._near is None or self._near[0] is not ids:
            among = first_emitted(len(ids), ids)
            some = np.union1d(among, children.near(ids, among[measured(len(among))]))
            self._near = ids, some, np.searchsorted(some, among)
        return self._near[1:]
