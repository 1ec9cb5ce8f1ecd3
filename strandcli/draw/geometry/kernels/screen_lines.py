"""Strands on the screen, as kernels take them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class ScreenLines(NamedTuple):
    """Polylines on the screen: strand s owns the vertices first[s] … first[s + 1] − 1."""

    first: NDArray[np.int64]
    """(S + 1,)"""
    screen: NDArray[np.float32]
    """(V, 3) x to the right and y down in pixels, and the depth number, which grows toward the eye; 0 where nothing is
    seen (see `strandcli.draw.view.kernels.project.points`)."""
    widths: NDArray[np.float32] | None
    """(V,) pixels; None: every line is one pixel wide."""
