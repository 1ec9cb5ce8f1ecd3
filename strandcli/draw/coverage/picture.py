"""What all layers of a picture of sorted strands share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..common.scratch import Scratch
from ..geometry.kernels.screen_lines import ScreenLines
from ..solids.edges import Edges
from ..view.kernels.depth_slope import DepthSlope
from .kernels.windows import BLOCK, MOST, PictureWindows, find_picture_windows

NO_WINDOWS = PictureWindows(np.zeros(0, np.float32), 0, 0)


@dataclass(frozen=True)
class Picture:
    """Input that all layers of a picture share."""

    lines: ScreenLines
    extents: NDArray[np.float32]
    """(S, `COLUMNS`) from `kernels.strand_extents.find_extents`."""
    stride: int
    """Every stride-th vertex is lit."""
    edges: Edges | None
    """Edges of the solids."""
    windows: PictureWindows
    depth_slope: DepthSlope
    closed: NDArray[np.uint8]
    """As in `tiles.Fragments`."""
    scratch: Scratch


def windows_of(edges: Edges | None, size: tuple[int, int], scratch: Scratch) -> PictureWindows:
    """Return the windows of a picture, behind which its solids hide strands; size: of the picture, samples."""
    across, down = (-(-samples // BLOCK) for samples in size)
    if edges is None or across * down >= MOST:
        return NO_WINDOWS
    blocks = scratch.borrow("hidden_blocks", across * down, np.float32)
    depths = scratch.borrow("hidden_windows", across * down + 1, np.float32)
    find_picture_windows(edges.hides, size[0], blocks, across, depths)
    return PictureWindows(depths, across, down)
