"""One opacity map (see `opacity`) as filter windows read it: cells of four texels, and layers in them. All numbers but
those of `DeepMap` are vectors."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ....jit import inlined
from ....simd import any_lane, floor, gather, gather2, gather4, where
from ...common.kernels.numbers import ONE, ZERO
from . import opacity


class DeepMap(NamedTuple):
    """One opacity map."""

    rows: Any
    """`pointer` to the maps."""
    start: Any
    """First index of the map, int64."""
    size: Any
    """Texels along a side, int64."""
    layers: Any
    """int64"""
    over: Any
    """float32: 1 / h of `opacity`, 1/m."""
    fronts: Any
    """`pointer` to the heads of cells and the pyramids of all maps, of `ShadowArrays`."""
    front: Any
    """First index of the map's pyramid, int64."""


@inlined
def cells_in(across, down, used, deep):
    """Return the mask of the cells in the columns `across` and rows `down` that are inside of a `DeepMap` where the
    mask `used` is set. Vectors."""
    last = np.float32((deep.size >> 1) - 1)
    return used & (across >= ZERO) & (down >= ZERO) & (across <= last) & (down <= last)


@inlined
def heads_of(across, down, there, d, deep):
    """Return nearest depth and `opacity.SCALE` of the cells in the mask `there`, d and 0 where there are no strands,
    and whether any has strands in front of the depths d. Vectors."""
    half = deep.size >> 1
    column = where(there, across, ZERO)
    front, scale = gather2(
        deep.fronts, deep.front - 2 * half * half, where(there, down, ZERO), 2 * half, column + column
    )
    some = there & (scale > ZERO)
    return where(some, front, d), where(some, scale, ZERO), any_lane(some & (front < d))


@inlined
def cell_at(across, down, there, deep):
    """Return the number of the row of a `DeepMap` for cells; 0 without strands, and outside of the mask `there`.
    Vectors."""
    half, column = deep.size >> 1, np.float32(opacity.HEAD) * where(there, across, ZERO)
    number = gather(deep.rows, deep.start + opacity.ROW, where(there, down, ZERO), opacity.HEAD * half, column)
    return where(there, number, ZERO)


@inlined
def layers_of(front, scale, d, deep):
    """Return the layer of depths d in cells and the position within it, and the farthest depth of strands, metres; d
    where there are none. front, scale: from `heads_of`. Vectors."""
    most = np.float32(deep.layers)
    some = scale > ZERO
    scale = where(some, scale, most + ONE)
    far = max((d - front) * deep.over, ZERO)
    ended = min(scale * (far / (far + ONE)), most)
    layer = min(floor(ended), most - ONE)
    back = where(some, front + most / ((scale - most) * deep.over), d)
    return layer, ended - layer, back


@inlined
def passed_at(number, layer, part, deep):
    """Return the optical depth of the first texel of cells at a position within a layer; 0 without strands. Vectors."""
    body, _ = rows_of(deep)
    passed = opacity.depth_at(deep.rows, body, number, layer, part, ZERO, deep.layers)
    return where(number > ZERO, passed, ZERO)


@inlined
def passed_in_cell(number, layer, part, deep):
    """Return the same of all four texels."""
    body, stride = rows_of(deep)
    low = gather4(deep.rows, body, number, stride, opacity.EACH * layer)
    high = gather4(deep.rows, body + opacity.TEXELS, number, stride, opacity.EACH * layer)
    some = number > ZERO
    return (
        where(some, low[0] + part * (high[0] - low[0]), ZERO), where(some, low[1] + part * (high[1] - low[1]), ZERO),
        where(some, low[2] + part * (high[2] - low[2]), ZERO), where(some, low[3] + part * (high[3] - low[3]), ZERO),
    )  # fmt: skip


@inlined
def rows_of(deep):
    """Return the index of the first row of a `DeepMap`, and the numbers of a row."""
    half = deep.size >> 1
    return deep.start + opacity.HEAD * half * half, opacity.TEXELS * (deep.layers + 1)
