"""Arrays of all shadow maps for kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class ShadowArrays(NamedTuple):
    """The maps of all lights. A light owns `MAP_COUNT` maps from number `light_columns.FIRST_MAP` on: opacity maps if
    its `MAP_LAYERS` is greater than 0, min/max maps otherwise."""

    texels: NDArray[np.float32]
    """(T, 2) nearest and farthest depth of each texel of all min/max maps, metres; no rows without such maps."""
    stacks: NDArray[np.float32]
    """(K,) all opacity maps, in the format described in `opacity`; empty without such maps."""
    starts: NDArray[np.int64]
    """(M,) first row in `texels`, or first index in `stacks`, of each map."""
    sizes: NDArray[np.int64]
    """(M,) texels along a side of each map."""
    views: NDArray[np.float32]
    """(M, `view_columns.SIZE`) the packed view of each map, in texels."""
    fronts: NDArray[np.float32]
    """(F,) from `strandcli.draw.shadows.fronts.tables_of_cells`; empty without opacity maps."""
    front_starts: NDArray[np.int64]
    """(M,) first index in `fronts` of each map's pyramid; 0 for a min/max map."""
