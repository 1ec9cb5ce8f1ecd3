"""Filter windows of `percentage_closer`: cells around each point, and weights of texels. All numbers are vectors.

The window of a point has a radius of R texels. Where R exceeds 6 texels only every second texel is read, beyond 12
every fourth, and so on to every sixteenth beyond 48, so that a window never costs more than one with R = 6. The weights
of the skipped texels fade to zero before they are skipped, so that the transition does not show. With 4 in place of 6
shadows on skin take two thirds of the time, but their edges are blotched where strands hang a little before it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ....jit import inlined
from ....simd import any_lane, broadcast, floor, gather, gather2, gather4, lane_count, reduce_max, store, where
from ...common.kernels.numbers import HALF, ONE, TWO, ZERO
from . import opacity

FOUR = np.float32(4.0)
EIGHT = np.float32(8.0)
SIXTEEN = np.float32(16.0)
MOST = np.float32(6.0)
"""Greatest radius, in texels that are read."""
WIDEST = SIXTEEN * MOST
"""Greatest radius, in texels of the map."""
FADED = np.float32(0.75)
"""Share of `MOST` at which every other texel begins to fade out."""


class FilterWindows(NamedTuple):
    """The windows of a vector of points."""

    u: Any
    v: Any
    """Column and row of the point, texels."""
    per: Any
    """1 / R."""
    stride: Any
    """Distance between the texels that are read."""
    jump: Any
    """Distance between the cells that are read, of 2 × 2 texels each; where `stride` is more than 1, of each the first
    texel."""
    fade: Any
    """How far every other texel has faded out, 0 to 1."""
    left: Any
    right: Any
    top: Any
    bottom: Any
    """First and last column and row; a window that is not used ends before it begins."""


@inlined
def windows_about(u, v, radius, used, step):
    """Return the windows of points, and the greatest number of columns and of rows of cells of any.

    radius: texels; used: mask of the points that have a window; step: distance between columns and rows, texels, which
    a large radius multiplies by a power of two.
    """
    times = where(radius > MOST, TWO, broadcast(radius, ONE))
    times = where(radius > TWO * MOST, FOUR, times)
    times = where(radius > FOUR * MOST, EIGHT, times)
    times = where(radius > EIGHT * MOST, SIXTEEN, times)
    stride = step * times
    share = ONE / stride
    left = -stride * floor((radius - u) * share)
    top = -stride * floor((radius - v) * share)
    right = where(used, floor(u + radius), left - stride)
    bottom = where(used, floor(v + radius), top - stride)
    fade = max((radius / (times * MOST) - FADED) * (ONE / (ONE - FADED)), ZERO)
    jump = max(HALF * stride, ONE)
    columns = np.int64(reduce_max((floor(HALF * right) - floor(HALF * left)) / jump + ONE))
    rows = np.int64(reduce_max((floor(HALF * bottom) - floor(HALF * top)) / jump + ONE))
    return FilterWindows(u, v, ONE / radius, stride, jump, fade, left, right, top, bottom), columns, rows


@inlined
def store_columns(windows, wide, rows, at):
    """Store the weights of the two columns of texels of each of `wide` columns of cells, from place `at` on, and return
    their sums."""
    left = right = ZERO * windows.u
    for column in range(wide):
        cell = column_of(windows, np.float32(column))
        one, two = weights(windows, cell + cell, windows.u, windows.left, windows.right)
        store(rows, at + 2 * column * lane_count(rows), one)
        store(rows, at + (2 * column + 1) * lane_count(rows), two)
        left = left + one
        right = right + two
    return left, right


@inlined
def column_of(windows, number):
    """Return a column of cells, counted from each window's first (float32)."""
    return floor(HALF * windows.left) + number * windows.jump


@inlined
def row_of(windows, number):
    """Return the same for a row, and the weights of its two rows of texels."""
    cell = floor(HALF * windows.top) + number * windows.jump
    one, two = weights(windows, cell + cell, windows.v, windows.top, windows.bottom)
    return cell, one, two


@inlined
def weights(windows, place, middle, first, last):
    """Return the weights of texels at an even place along an axis, and of those after them: 0 where not read."""
    half = place * (HALF / windows.stride)
    odd = TWO * (half - floor(half))  # 1 for every other texel, else 0
    one = (ONE - windows.fade * odd) * bell(windows, place, middle, first, last)
    two = (ONE - windows.fade) * bell(windows, place + ONE, middle, first, last)
    return one, where(windows.stride > ONE, ZERO, two)


@inlined
def bell(windows, place, middle, first, last):
    """Return the weights of texels along an axis by their distance from the middle; 0 outside of the window."""
    aside = (place - middle) * windows.per
    aside = ONE - aside * aside
    return where((place >= first) & (place <= last), aside * aside, ZERO)


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
    half, column = deep.size >> 1, np.float32(opacity.HEAD) * where(there, across, ZERO)
    front, scale = gather2(deep.rows, deep.start, where(there, down, ZERO), opacity.HEAD * half, column)
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
    body, stride = rows_of(deep)
    low = gather(deep.rows, body, number, stride, opacity.EACH * layer)
    high = gather(deep.rows, body, number, stride, opacity.NEXT + opacity.EACH * layer)
    return where(number > ZERO, low + part * (high - low), ZERO)


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
