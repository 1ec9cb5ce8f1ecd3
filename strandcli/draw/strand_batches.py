"""The strands of one exposure, batch by batch, so that memory stays bounded however many there are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..constants import BATCH_VERTICES, W
from ..scene.model import Curves, Scene
from .common.drawing import Drawing
from .common.scratch import Scratch
from .coverage.kernels.width_profiles import Profiles
from .coverage.width_profiles import profiles_of
from .geometry.curves import Polylines, flatten, greatest_pieces
from .geometry.detail import Level
from .geometry.extent import widths_of
from .geometry.kernels import detail, silhouette
from .view.camera import View
from .zbuffer import raster


@dataclass(frozen=True)
class Strands:
    """The strands of one exposure."""

    positions: NDArray[np.float32]
    """(blocks, n + 1, 3 W) metres."""
    lengths: NDArray[np.float32] | None
    """(blocks, W) rest lengths of their segments; None where those of a strand differ."""
    count: int
    level: Level | None
    """What is drawn of each; None: all of it."""


@dataclass(frozen=True)
class StrandBatch:
    """Strands begin <= s < end as a camera sees them."""

    begin: int
    end: int
    lines: Polylines
    screen: NDArray[np.float32]
    """(V, 3) see `strandcli.draw.zbuffer.raster.to_screen`."""
    widths: NDArray[np.float32] | None
    """(V,) pixels; None: lines a pixel wide."""
    profiles: Profiles | None
    """Light across wide strands; None also where shadows are exact: it is made when it is known what is seen."""


@dataclass(frozen=True)
class StrandBatches:
    """The strands of one exposure, and how they are seen."""

    scene: Scene
    positions: NDArray[np.float32]
    """(blocks, n + 1, 3 W) metres."""
    lengths: NDArray[np.float32] | None
    """(blocks, W) rest lengths of segments, metres; None where those of a strand differ."""
    level: Level | None
    view: View
    thins: bool
    """Whether what fades becomes thinner; else it becomes shorter."""
    ranges: list[tuple[int, int]]
    """From `cut`."""
    shaded: bool
    """Whether strands cast shadows, and are needed off the screen too."""
    traced: int
    """Lights with exact shadows: these are finer than half a segment, and light is wanted at every vertex."""
    drawing: Drawing
    scratch: Scratch

    def lines(self) -> Iterator[Polylines]:
        """Curves only, a batch at a time, each to be used before the next is asked for."""
        for begin, end in self.ranges:
            yield self._flatten(begin, end)

    def seen(self, least: float, lines: Polylines | None = None) -> Iterator[StrandBatch]:
        """Batch after batch, each to be used before the next is asked for.

        ``least``: width in pixels that a strand has at the least; ``lines``: those of the only batch, where they
        are known already.
        """
        scene, scratch = self.scene, self.scratch
        for begin, end in self.ranges:
            here = self._flatten(begin, end) if lines is None else lines
            screen = raster.to_screen(here, self.view, scratch)
            if self.traced:
                silhouette.move_ends(
                    here.first, here.world, self.view.pack(), np.float32(scene.material.width),
                    np.float32(scene.material.taper), here.scale, screen,
                )  # fmt: skip
            widths = widths_of(here, screen, self.view, scene.material, least, self.thins, scratch)
            profiles = None
            if scene.material.rounded and not self.traced:
                profiles = profiles_of(here, screen, widths, scene.image.supersample, scratch)
            self.drawing.lap("curves")
            yield StrandBatch(begin, end, here, screen, widths, profiles)

    def _flatten(self, begin: int, end: int) -> Polylines:
        blocks, level = slice(begin // W, -(-end // W)), self.level
        fade = None if level is None else level.fade[begin:end]
        lines = flatten(
            self.positions[blocks], None if self.lengths is None else self.lengths[blocks], end - begin,
            self.scene.curves, self.view, self.shaded, self.scratch, fade,
        )  # fmt: skip
        if level is not None:
            lines = replace(lines, scale=level.scale[begin:end])
            if not self.thins:
                detail.shorten(lines.first, lines.world, level.fade[begin:end])
        if self.traced:
            lines = replace(lines, stride=1)
        if lines.error is not None:
            self.drawing.curve_px_max = max(lines.error, self.drawing.curve_px_max or 0.0)
        self.drawing.lap("curves")
        return lines


def cut(strands: int, n: int, curves: Curves) -> list[tuple[int, int]]:
    """Ranges of strands of n segments, whole blocks each, that hold at most `BATCH_VERTICES` vertices."""
    vertices = (n - 1) * greatest_pieces(curves) + 1
    step = max(BATCH_VERTICES // vertices // W, 1) * W
    return [(begin, min(begin + step, strands)) for begin in range(0, strands, step)]
