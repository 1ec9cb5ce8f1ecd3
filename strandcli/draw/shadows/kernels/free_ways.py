"""How far light comes freely past solids that have distances of vectors, in a table over each light's view.

Nearly all strands that the camera sees have no solid between them and a light. Where its rays are parallel each column
of the view has a depth before which nothing hides any of the light. A look-up of it takes the place of a walk through
distances for each vertex; only behind it is one needed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import W
from ....jit import device, parallel, prange
from ....simd import broadcast, floor, gather, lane_count, load, load3, pointer, store, where
from ....solids.kernels import other
from ...common.kernels import view_columns as at
from ...common.kernels.batch import LEAST, LIST, RADIUS, WX, X, set_vector, vector_at
from ...common.kernels.light_columns import LIGHT_SIZE
from ...common.kernels.numbers import HALF, ONE, ZERO
from .minmax import texel_of
from .penumbra import SHARP

SIDE = 128
"""Columns and rows of a table."""
ROOM = 16
"""Numbers beyond the last row, for vectors."""


class FreeWays(NamedTuple):
    """Tables of all lights."""

    depths: NDArray[np.float32]
    """(lights, `SIDE`, `SIDE`) depth up to which all of the light is seen, metres, between each entry and those after
    it: the last of a row, and the last row, have no meaning. No rows: there are no tables."""
    views: NDArray[np.float32]
    """(lights, `view_columns.SIZE`) packed views, in columns of the table."""


@parallel
def measure(lights, views, solids, skin, depths):
    """Write for each light how far its rays go until a solid may hide some of it to depths (lights, `SIDE`, `SIDE`).

    lights (n, `light_columns.COLUMNS`): directional ones; views (n, `view_columns.SIZE`); solids:
    `strandcli.solids.Solids`; skin: as in `soft_shadows`."""
    for task in prange(lights.shape[0] * SIDE):
        i, row = np.int64(task) // SIDE, np.int64(task) % SIDE
        work = np.empty(SIDE + ROOM, np.float32)
        for column in range(SIDE):
            work[column] = np.float32(column)
        rows = pointer(work)
        per = ONE / views[i, at.FOCAL]
        up = (views[i, at.AXIS_Y] - HALF - np.float32(row)) * per
        light = max(lights[i, LIGHT_SIZE], SHARP), skin, skin
        for k in range(0, SIDE, lane_count(rows)):
            right = (load(rows, k) + (HALF - views[i, at.AXIS_X])) * per
            none = ZERO * right
            point = (
                right * views[i, at.RIGHT_X] + (up * views[i, at.UP_X] + views[i, at.EYE_X]),
                right * views[i, at.RIGHT_X + 1] + (up * views[i, at.UP_X + 1] + views[i, at.EYE_X + 1]),
                right * views[i, at.RIGHT_X + 2] + (up * views[i, at.UP_X + 2] + views[i, at.EYE_X + 2]),
            )
            way = (
                none + views[i, at.FORWARD_X], none + views[i, at.FORWARD_X + 1], none + views[i, at.FORWARD_X + 2],
            )  # fmt: skip
            store(rows, k, other.free_depth(solids, point, way, none + views[i, at.DEPTH_RANGE], light))
        for column in range(SIDE):
            depths[i, row, column] = work[column]


@device
def list_others(work, n, i, free):
    """List the points of a batch of which the table of light number i does not say that they see all of it, in the row
    `LIST`; return how many. Rows of `batch`: positions, `RADIUS`, `LEAST`."""
    views = free.views
    for k in range(n):
        set_vector(work, WX, k, texel_of(vector_at(work, X, k), views, i))
    rows, table = pointer(work), pointer(free.depths)
    start, edge = i * (SIDE * SIDE), np.float32(SIDE - 1)
    for k in range(0, n, lane_count(rows)):
        u, v, d = load3(rows, WX + k, W)
        inside = (u >= ZERO) & (v >= ZERO) & (u < edge) & (v < edge)
        column, row = where(inside, floor(u), ZERO), where(inside, floor(v), ZERO)
        sees = inside & (d < gather(table, start, row, SIDE, column))
        asked = ~sees & (load(rows, LEAST + k) > -load(rows, RADIUS + k))
        store(rows, WX + k, where(asked, broadcast(rows, ONE), ZERO))
    count = np.int64(0)
    for k in range(n):
        work[LIST + count] = np.float32(k)
        count += np.int64(work[WX + k])
    return count
