"""Shadow maps as kernels read them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class ShadowArrays(NamedTuple):
    """The maps of all lights. A light has the maps from `light_columns.FIRST_MAP` on, `MAP_COUNT` of them; they are
    opacity maps where its `MAP_LAYERS` is above 0, and min/max maps elsewhere."""

    texels: NDArray[np.float32]
    """(T, 2) nearest and farthest depth of each texel of every min/max map, metres; no rows where there is none."""
    stacks: NDArray[np.float32]
    """(K,) every opacity map, as `opacity` describes it; empty where there is none."""
    starts: NDArray[np.int64]
    """(M,) where each map begins: its row of `texels`, or its place in `stacks`."""
    sizes: NDArray[np.int64]
    """(M,) texels along a side of each map."""
    views: NDArray[np.float32]
    """(M, `view_columns.SIZE`) the packed view of each map, in texels."""
