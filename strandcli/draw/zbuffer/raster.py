"""Visibility of strands in the z-buffer: projection, sorting into bands of rows, and rasterisation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...errors import RefusedError
from ..common.kernels.keys import FIRST
from ..common.kernels.view_columns import FLAT, DepthSlope
from ..common.scratch import Scratch
from ..geometry.curves import Polylines
from ..geometry.kernels.ribbon import ScreenLines
from ..view.camera import View
from ..view.kernels import project
from .kernels import bands as lists
from .kernels import raster as kernel
from .kernels.bands import Bands

ROWS = 64
"""Height of a band."""


def to_screen(
    lines: Polylines, view: View, scratch: Scratch, name: str = "screen", stride: int = 1
) -> NDArray[np.float32]:
    """Return (V, 3) x and y in pixels, and the depth number of `kernels.project.points`, which grows toward the eye, of
    every ``stride``-th vertex of each strand, ends included."""
    strands = len(lines.first) - 1
    screen = scratch.borrow(name, ((len(lines.world) - strands) // stride + strands, 3), np.float32)
    project.points(lines.first, lines.world, stride, view.pack(), screen)
    return screen


def sort_into_bands(
    first: NDArray[np.int64], screen: NDArray[np.float32], height: int, margin: float, workers: int, scratch: Scratch
) -> Bands:
    """Return strands sorted into bands of `ROWS` rows, or one band for a single worker. The picture does not depend on
    the bands. margin: half the greatest width of a line, pixels."""
    if workers == 1:
        strands = len(first) - 1
        return Bands(np.array([0, strands]), scratch.arange(strands), height, workers)
    ranges = scratch.borrow("ranges", (len(first) - 1, 2), np.int32)
    lists.find(first, screen, height, ROWS, np.float32(margin), ranges)
    begin = np.zeros(-(-height // ROWS) + 1, np.int64)
    lists.count(ranges, begin)
    members = scratch.borrow("members", int(begin[-1]), np.int32)
    lists.scatter(ranges, begin[:-1].copy(), members)
    return Bands(begin, members, ROWS, workers)


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
    margin = 1.0 if widths is None or not len(widths) else float(widths.max()) + 1.0
    bands = sort_into_bands(lines.first, screen, height, margin, workers, scratch)
    kernel.draw_strands(ScreenLines(lines.first, screen, widths), depth_slope, bands, width, height, base, keys)
