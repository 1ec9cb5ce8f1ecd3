"""How far light comes freely past solids, found once an exposure for all strands (see `kernels.free_ways`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...solids import Solids
from ..common.kernels.light_columns import COLUMNS, KIND, LIGHT_SIZE, PLACE_X
from ..common.kernels.view_columns import SIZE
from ..view.camera import parallel_view
from .kernels import free_ways as kernel
from .kernels.free_ways import SIDE, FreeWays

NO_FREE_WAYS = FreeWays(np.zeros((0, SIDE, SIDE), np.float32), np.zeros((0, SIZE), np.float32))


def free_ways(
    lights: NDArray[np.float32], solids: Solids | None, skin: np.float32, bounds: NDArray[np.float64]
) -> FreeWays:
    """Return the tables over the box ``bounds`` (2, 3) of strands, metres; without rows where solids have no distances
    of vectors, or a light is not directional, or none has a size.

    lights (n, `light_columns.COLUMNS`); skin: as in `kernels.soft_shadows`."""
    by_vectors = getattr(type(solids), "distances_in_own", None) is not None
    if solids is None or not by_vectors or not lights[:, LIGHT_SIZE].any() or lights[:, KIND].any():
        return NO_FREE_WAYS
    assert lights.shape[1] == COLUMNS
    views = np.stack([parallel_view(-row[PLACE_X : PLACE_X + 3], SIDE, bounds).pack() for row in lights])
    depths = np.empty((len(lights), SIDE, SIDE), np.float32)
    kernel.measure(lights, views, solids, skin, depths)
    depths[:, :, :-1] = np.minimum(depths[:, :, :-1], depths[:, :, 1:])
    depths[:, :-1] = np.minimum(depths[:, :-1], depths[:, 1:])
    return FreeWays(depths, views)
