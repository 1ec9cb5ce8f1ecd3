"""Batches of the strands of one exposure, which bound the memory for any number of strands."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..constants import BAND_VERTICES, BATCH_VERTICES, W
from ..scene.model import Curves, Scene
from .common.drawing import Drawing
from .common.scratch import Scratch
from .coverage.kernels import width_profiles
from .coverage.kernels.width_profiles import Profiles
from .geometry import curves as curve
from .geometry.curves import Polylines, greatest_pieces
from .geometry.detail import Level
from .geometry.extent import lost_of, widths_of
from .geometry.kernels.curves import shorten
from .view.camera import View
from .zbuffer import raster

WIDE, WIDEST = 2.0, 4.0
"""Widths, pixels, from which profiles begin to count, and count fully."""


@dataclass(frozen=True)
class Whole:
    """Strands of which level of detail draws some, and the others are not made."""

    count: int
    """Number of them all."""
    numbers: NDArray[np.int64]
    """Where those that are drawn are among them, ascending."""
    around: Callable[[], tuple[NDArray[np.float32], int, NDArray[np.int64]]]
    """Makes those that are near the points where `strandcli.draw.geometry.spacing.spacing_of` measures: its
    arguments."""


@dataclass(frozen=True)
class Strands:
    """The strands of one exposure."""

    positions: NDArray[np.float32]
    """(blocks, n + 1, 3 W) metres."""
    lengths: NDArray[np.float32] | None
    """(blocks, W) rest length of each strand's segments, metres; None if the segments of a strand differ."""
    count: int
    """Number of strands."""
    level: Level | None
    """Level of detail; None: all strands are drawn whole."""
    tones: NDArray[np.float32]
    """(count,) in [−1, 1): deviation of each strand's colour from the mean."""
    ids: NDArray[np.int32] | None
    """(count,) number of each in the order of emission; None: 0, 1, …"""
    whole: Whole | None = None
    """None: strands that level of detail does not draw are among them."""
    shares: NDArray[np.float32] | None = None
    """(count, n) of each strand's width at its points, root to tip, in [0, 1]; None: 1."""

    @property
    def total(self) -> int:
        """Number of strands, with those of which level of detail draws these."""
        return self.count if self.whole is None else self.whole.count

    @property
    def fade(self) -> NDArray[np.float32] | None:
        """(count,) from the level of detail; None: all strands are drawn whole."""
        return None if self.level is None else self.level.fade

    @property
    def numbers(self) -> NDArray[np.int64] | None:
        """(count,) where these are among them all; None: 0, 1, …"""
        return None if self.whole is None else self.whole.numbers


@dataclass(frozen=True)
class StrandBatch:
    """The strands begin <= s < end on the screen."""

    begin: int
    end: int
    lines: Polylines
    tones: NDArray[np.float32]
    """(end − begin,) of the strands, as in `Strands`."""
    screen: NDArray[np.float32]
    """(V, 3) from `strandcli.draw.zbuffer.raster.to_screen`."""
    widths: NDArray[np.float32] | None
    """(V,) samples; None: lines one sample wide."""
    profiles: Profiles | None
    """Light across wide strands; None if no strand is wide."""


@dataclass(frozen=True)
class StrandBatches:
    """The strands of one exposure, their view, and how they are divided into batches."""

    scene: Scene
    strands: Strands
    view: View
    thins: bool
    """Whether strands that fade become thinner; else they become shorter."""
    ranges: list[tuple[int, int]]
    """First strand and end of each batch, from `divide`."""
    off_screen: bool
    """Whether strands off the screen are needed too, because they cast shadows."""
    drawing: Drawing
    scratch: Scratch

    def lines(self) -> Iterator[Polylines]:
        """Yield the polylines of each batch; they are valid until the next are requested."""
        for begin, end in self.ranges:
            yield self.flatten(begin, end)

    def seen(self, least: float, lines: Polylines | None = None) -> Iterator[StrandBatch]:
        """Yield each batch on the screen; it is valid until the next is requested.

        ``least``: least width of a strand, samples; ``lines``: polylines of the only batch, if they exist already.
        """
        for begin, end in self.ranges:
            yield self.on_screen(begin, end, self.flatten(begin, end) if lines is None else lines, least)

    def on_screen(self, begin: int, end: int, lines: Polylines, least: float) -> StrandBatch:
        """Return the strands begin <= s < end on the screen; least: as in `seen`."""
        scene, scratch = self.scene, self.scratch
        screen = raster.to_screen(lines, self.view, scratch)
        widths = widths_of(lines, screen, self.view, scene.material, least, self.thins, scratch)
        profiles = self.profiles(screen, widths)
        self.drawing.lap("curves")
        return StrandBatch(begin, end, lines, self.strands.tones[begin:end], screen, widths, profiles)

    def profiles(self, screen: NDArray[np.float32], widths: NDArray[np.float32] | None) -> Profiles | None:
        """Return profiles as `profiles_of`; None if the material has none."""
        if not self.scene.material.rounded:
            return None
        return profiles_of(screen, widths, self.scene.image.supersample, self.scratch)

    def flatten(self, begin: int, end: int, shown: NDArray[np.bool_] | None = None) -> Polylines:
        """Return the polylines of the strands begin <= s < end; shown (end - begin,): of which of them, None: all."""
        strands, blocks = self.strands, slice(begin // W, -(-end // W))
        level = strands.level
        fade = None if level is None else level.fade[begin:end]
        if shown is not None:
            fade = np.where(shown, np.float32(1) if fade is None else fade, np.float32(0))
        curves = self.scene.curves
        shares = None if strands.shares is None else strands.shares[begin:end]
        radii = None
        if shares is not None and level is not None and curves.mode == "thinned":
            radii = shares * (np.float32(0.5 * self.scene.material.width) * level.scale[begin:end, None])
        lines = curve.flatten(
            strands.positions[blocks], None if strands.lengths is None else strands.lengths[blocks], end - begin,
            curves, self.view, self.off_screen, self.scratch, fade, radii,
        )  # fmt: skip
        if shares is not None:
            lines = replace(lines, lost=lost_of(lines, shares, self.scratch))
        if level is not None:
            lines = replace(lines, scale=level.scale[begin:end])
            if not self.thins:
                shorten(lines.first, lines.world, level.fade[begin:end])
        if lines.error is not None:
            self.drawing.curve_px_max = max(lines.error, self.drawing.curve_px_max or 0.0)
        self.drawing.lap("curves")
        return lines


def divide(strands: int, n: int, curves: Curves, sorted_points: int | None) -> list[tuple[int, int]]:
    """Return ranges (begin, end) of strands of n points, whole blocks, if a block has no more with at most
    `BATCH_VERTICES` vertices; of strands that are sorted, where there are more than ``sorted_points``, with about
    `BAND_VERTICES`."""
    most = (n - 1) * greatest_pieces(curves) + 1
    at_once = BATCH_VERTICES // most
    if sorted_points is not None:  # adaptive curves have half of the pieces that they may have, about
        several = 2 * BAND_VERTICES // (most + n)
        at_once = several if strands * n > sorted_points else strands + W - 1
    step = max(at_once // W, 1) * W
    return [(begin, min(begin + step, strands)) for begin in range(0, strands, step)]


def profiles_of(
    screen: NDArray[np.float32], widths: NDArray[np.float32] | None, samples: int, scratch: Scratch
) -> Profiles | None:
    """Return profiles, not yet filled, for the wide vertices of polylines; None if there are none.

    screen (V, 3), widths (V,): samples; ``samples``: along a side of a pixel."""
    if widths is None or not len(widths) or not float(widths.max()) > WIDE * samples:
        return None
    wide = (widths > np.float32(WIDE * samples)) & (screen[:, 2] > 0)
    count = int(np.count_nonzero(wide))
    if count == 0:
        return None
    slots = scratch.borrow("slots", len(widths), np.int32)
    slots.fill(-1)
    slots[wide] = np.arange(count, dtype=np.int32)
    profile = scratch.borrow("profile", (count, width_profiles.COLUMNS + 1, 3), np.float32)
    return Profiles(screen, widths, np.float32(samples), np.float32(WIDE), np.float32(WIDEST), slots, profile)
