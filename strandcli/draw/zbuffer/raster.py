"""Visibility of strands in the z-buffer: projection and rasterisation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...errors import RefusedError
from ..common.kernels.keys import FIRST
from ..common.kernels.view_columns import FLAT, DepthSlope
from ..common.scratch import Scratch
from ..geometry.curves import Polylines
from ..geometry.extent import extents_on_screen
from ..geometry.kernels import ribbon
from ..geometry.kernels.ribbon import ScreenLines
from ..view.camera import View
from ..view.kernels import project
from .kernels import raster as kernel

ROWS = 64
"""Height of a band of rows."""


def to_screen(lines: Polylines, view: View, scratch: Scratch, name: str = "screen") -> NDArray[np.float32]:
    """Return (V, 3) x and y in pixels, and the depth number of `kernels.project.points`, which grows toward the eye."""
    screen = scratch.borrow(name, lines.world.shape, np.float32)
    project.points(lines.first, lines.world, view.pack(), screen)
    return screen


def bands_of(
    first: NDArray[np.int64], screen: NDArray[np.float32], widths: NDArray[np.float32] | None, size: tuple[int, int],
    workers: int, scratch: Scratch,
) -> kernel.Bands:  # fmt: skip
    """Return the bands that workers share in a picture of a size (width, height); widths: as in `ScreenLines`."""
    width, height = size
    if workers == 1:  # one band has all strands, and to measure them takes as long as a fifth of drawing them
        extents = scratch.borrow("extents", (len(first) - 1, ribbon.COLUMNS), np.float32)
        extents[:, ribbon.LEAST_Y], extents[:, ribbon.GREATEST_Y] = -np.inf, np.inf
        return kernel.Bands(extents, height, workers)
    return kernel.Bands(extents_on_screen(first, screen, widths, width, scratch), ROWS, workers)


def draw(
    lines: Polylines,
    screen: NDArray[np.float32],
    widths: NDArray[np.float32] | None,
    base: int,
    size: tuple[int, int],
    workers: int,
    scratch: Scratch,
    keys: NDArray[np.uint64],
    depth_slope: DepthSlope = FLAT,
) -> None:
    """Draw polylines into a z-buffer ``keys`` (height * width,), their vertices numbered from ``base``; depth_slope:
    of the view, for the depth of wide strands, which are round.

    Raises `RefusedError` if vertex numbers would reach those of the solids.
    """
    if base + len(lines.world) > int(FIRST):
        raise RefusedError(
            f"a picture holds at most {int(FIRST):,} vertices of strands: use fewer --strands or a lower curves.level"
        )
    width, height = size
    bands = bands_of(lines.first, screen, widths, size, workers, scratch)
    kernel.draw_strands(ScreenLines(lines.first, screen, widths), depth_slope, bands, width, height, base, keys)
