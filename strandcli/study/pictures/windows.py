"""A preset's whole frame, seen through a few small windows: the same strands, pixels and shadows as in the picture."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.common.scratch import Scratch
from ...draw.film.film import backdrop_of
from ...draw.geometry.curves import Polylines
from ...draw.shadows.shadow import ShadowMaps
from ...draw.strand_batches import StrandBatches, Strands
from ...draw.view.camera import View
from ...errors import UsageError
from ...scene.model import Scene
from ..sweep import Request, changed
from .subject import LinearRenderer, Picture, Subject

SIDE = 32
"""Of a window, pixels, at most."""
WINDOWS = 8
"""That a picture is judged by; half as many where there are `MANY` particles."""
MANY = 2_000_000
SAMPLED = ("raster", "shade", "film")
"""Stages whose time grows with the samples."""
MARGIN = 96
"""Pixels about a window in which curves are as fine as in it."""
MAPPED = 4
"""Samples along a pixel's side, at most, that curves in shadow maps are made for: more show nothing there."""

Window = tuple[int, int, int, int]
"""x, y of the upper left corner, width and height, pixels."""


@dataclass(frozen=True)
class WindowBatches(StrandBatches):
    """Batches of strands of a window, with the polylines of a view of more than that: adaptive curves are coarse where
    a view ends, and light at the ends of coarse pieces would show in the window."""

    wide: View

    def flatten(self, begin: int, end: int, shown: NDArray[np.bool_] | None = None) -> Polylines:
        return StrandBatches.flatten(replace(self, view=self.wide), begin, end, shown)


class WindowRenderer(LinearRenderer):
    """Draws windows of a picture one after the other, with shadow maps and occlusion that are made once.

    Strands are drawn into the maps as they are for the whole picture.
    """

    keeps_light = True

    def show(self, window: Window) -> None:
        """Take a window for the next picture; all are of one size."""
        self.scene = changed(self.scene, {"image.crop": window})
        self.backdrop = backdrop_of(self.scene.image)

    def _batches(self, strands: Strands, view: View, mapped: bool) -> WindowBatches:
        made, samples = super()._batches(strands, view, mapped), self.scene.image.supersample
        known = {one.name: getattr(made, one.name) for one in fields(StrandBatches)}
        margin = samples * MARGIN
        wide = replace(view.cropped(-margin, -margin, view.width + 2 * margin, view.height + 2 * margin), window=None)
        return WindowBatches(**known, wide=wide)

    def _fill_maps(self, maps: ShadowMaps, batches: StrandBatches, lines: Any, workers: int) -> None:
        """As in `Renderer`; ``lines`` stay as they are."""
        assert isinstance(batches, WindowBatches)
        image, view = self.scene.image, batches.view
        samples = min(image.supersample, MAPPED)
        shrunk = samples / image.supersample
        x, y = (image.supersample * side for side in (image.crop or (0, 0))[:2])
        (cx, cy), (width, height) = view.middle, image.size
        whole = replace(
            view, width=samples * width, height=samples * height, focal=shrunk * view.focal,
            centre=(shrunk * (cx + x), shrunk * (cy + y)), window=None,
        )  # fmt: skip
        super()._fill_maps(maps, replace(batches, view=whole, wide=whole, scratch=Scratch()), None, workers)


class Windows(Subject):
    """All strands of a frame, drawn in a few windows of its picture that have strands in them.

    Windows are pictures of their own, one below the other in what `draw` returns. Shadow maps and occlusion are made
    once for all of them, of all strands.
    """

    def __init__(self, request: Request) -> None:
        scene = request.single
        self.windows: list[Window] = []
        self.mean = 0.0
        """Light of all of the picture that has strands."""
        self._share = 1.0
        """Pixels that have strands over those of the windows."""
        self._own: dict[str, tuple[float, float]] = {}
        """Seconds by stage of the whole frame and of its windows, with the scene's own settings."""
        super().__init__(replace(request, strands=scene.drawn_strands, size=scene.image.size))

    def move(self) -> None:
        """As in `Subject`; then draw the frame once as the scene has it, and choose the windows by that. Raises
        `UsageError` where the frame shows no strands."""
        super().move()
        if self.windows:
            return
        whole = self.draw_whole(changed(self.scene, {"image.aovs": ("mask",)}))
        corner = self.scene.image.crop or (0, 0)
        number = WINDOWS if self.scene.emitter.strands * self.scene.emitter.particles < MANY else WINDOWS // 2
        self.windows, self.mean, tiles = spread(whole.aovs["mask"], whole.image, corner[:2], number)
        if not self.windows:
            raise UsageError(f"{self.name}: frame {self.frame} shows no strands; choose the settings by hand")
        self._share = tiles / len(self.windows)

    def draw(self, scene: Scene, draws: int = 1, *args: Any, **kwargs: Any) -> Picture:
        """Draw a scene in all windows. Seconds are the sums of a stage, or after `calibrate` those of a whole frame."""
        renderer = WindowRenderer(changed(scene, {"image.crop": self.windows[0]}), self.groom)
        made = []
        for window in self.windows:
            renderer.show(window)
            made.append(super().draw(renderer.scene, draws, renderer=renderer))
        seconds: dict[str, float] = {}
        counts: dict[str, int] = {}
        for picture in made:
            for stage, took in picture.seconds.items():
                seconds[stage] = seconds.get(stage, 0.0) + took
            for name, value in picture.counts.items():
                counts[name] = max(value, counts.get(name, 0))
        image = np.concatenate([picture.image for picture in made])
        pixels = np.concatenate([picture.pixels for picture in made if picture.pixels is not None])
        return Picture(image, self._of_frame(seconds), counts, pixels=pixels)

    def draw_whole(self, scene: Scene) -> Picture:
        """Draw the whole frame."""
        return super().draw(scene, 1)

    def calibrate(self) -> float:
        """Draw the whole frame with the scene's own settings, and return the seconds that it took: by what windows take
        with these, `draw` learns what a frame takes with more."""
        whole = self.draw_whole(self.scene).seconds
        self._own = {}
        parts = self.draw(self.scene).seconds
        self._own = {stage: (took, parts[stage]) for stage, took in whole.items() if parts.get(stage)}
        return sum(whole.values())

    def _of_frame(self, seconds: dict[str, float]) -> dict[str, float]:
        """What a whole frame takes by stage where its windows take ``seconds``; these where nothing is known. What more
        samples take grows with the pixels that have strands, all else in proportion."""
        found = {}
        for stage, took in seconds.items():
            whole, part = self._own.get(stage, (took, took))
            more = stage in SAMPLED and took > part
            found[stage] = whole + self._share * (took - part) if more else whole * took / part if part else took
        return found

    def apart(self, stacked: NDArray[Any]) -> list[NDArray[Any]]:
        """The windows of a picture that `draw` returned."""
        return np.split(stacked, len(self.windows))


def spread(
    mask: NDArray[np.float32], picture: NDArray[np.float64], corner: tuple[int, int], number: int
) -> tuple[list[Window], float, int]:
    """Windows that stand for all of a picture that has strands, the mean light of all that, and how many they are of.

    mask (height, width): the share of each pixel that strands cover; picture (height, width, 3): linear light, its
    upper left pixel at ``corner``. The picture is cut into tiles of `SIDE` pixels (smaller where it is), those without
    strands are left out, the rest are put in order of how much neighbouring pixels differ, which errors go with; of
    ``number`` equal parts of this list, each gives the tile in its middle.
    """
    height, width = mask.shape
    wide, high = min(SIDE, width), min(SIDE, height)
    columns, rows = width // wide, height // high
    left, top = (width - columns * wide) // 2, (height - rows * high) // 2
    inner = slice(top, top + rows * high), slice(left, left + columns * wide)
    tiles = picture[inner].reshape(rows, high, columns, wide, 3)
    occupied = np.flatnonzero(mask[inner].reshape(rows, high, columns, wide).any((1, 3)))
    if not len(occupied):
        return [], 0.0, 0
    means = tiles.mean((1, 3, 4)).reshape(-1)
    rough = ((np.diff(tiles, axis=1) ** 2).sum((1, 3, 4)) + (np.diff(tiles, axis=3) ** 2).sum((1, 3, 4))).reshape(-1)
    order = occupied[np.argsort(rough[occupied], kind="stable")]
    number = min(number, len(order))
    places = [min(math.floor((part + 0.5) * len(order) / number), len(order) - 1) for part in range(number)]
    chosen = [divmod(int(order[place]), columns) for place in places]
    x, y = corner[0] + left, corner[1] + top
    found = [(x + column * wide, y + row * high, wide, high) for row, column in chosen]
    return found, float(means[occupied].mean()), len(occupied)
