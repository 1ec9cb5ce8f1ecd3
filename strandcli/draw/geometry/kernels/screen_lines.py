"""Polylines on the screen, as a tuple for kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class ScreenLines(NamedTuple):
    """Polylines on the screen: strand s owns the vertices first[s] … first[s + 1] − 1."""

    first: NDArray[np.int64]
    """(S + 1,)"""
    screen: NDArray[np.float32]
    """(V, 3) x to the right and y down, pixels, and the depth number, which grows toward the eye; 0 for a vertex that
    is not seen (see `strandcli.draw.view.kernels.project.points`)."""
    widths: NDArray[np.float32] | None
    """(V,) pixels; None: every line is one pixel wide."""
