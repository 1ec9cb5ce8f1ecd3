"""Deep opacity maps (Yuksel & Keyser 2008): optical depth of strands toward a light, by texel and depth layer.

docs/shadows.md has the layers of a cell and what a piece of a strand adds to them. Layers are nearly uniform within a
few times h, where light falls off, and coarse behind that, where it is dark. Crowded strands avoid each other and cover
more: τ is increased by a part of itself that is proportional to τ and to (width / distance between strands)².

A cell is 2×2 texels whose layers have the same depths, so their mean is one texel twice as wide. Where the layers near
a point show that strands lie far apart, `corrected_depth` uses the cell means instead, and a blend between the two: a
density estimate with an adaptive window. The layers that measure the distance span as much depth as the window is wide,
because a thin layer contains one strand or none. A strand's own contribution in front of itself, half of what it adds
at the window's centre, is subtracted.

A cell's head is nearest depth, n (1 + h / D), the number of its row, and τ of all strands in each of the four texels;
in its row stands for each layer boundary the τ in front of it, in each of them. Within a layer τ is linear. A map is
one flat array: the heads of all cells, for neighbours are looked up together, and then the rows. All empty cells, nine
tenths of a ponytail's map, share row 0.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ....jit import device, inlined
from ....simd import any_lane, floor, gather4, gather8, where
from ...common.kernels.numbers import HALF, ONE, ZERO
from .minmax import bilinear

TINY = np.float32(1e-12)
START, SCALE, ROW, WHOLE = 0, 1, 2, 4
"""Offsets in a head of the nearest depth, metres; of n (1 + h / D); of the number of the cell's row, 0 without strands;
and of τ in front of the last layer's end, in each of the four texels."""
HEAD = 8
"""Numbers of a head."""
TEXELS = 4
"""Texels of a cell, and so numbers of a layer boundary."""
OWN = np.float32(0.375)
"""Half of what a strand one texel wide has on its own middle line, 2/3 along the map's axes to .78 between them."""
NEXT = np.float32(TEXELS)
"""Offset in a row of the second layer boundary."""
EACH = np.float32(TEXELS)
"""Distance between layer boundaries."""
CLOSE = np.float32(0.8)
"""Distance between strands, in texels, up to which single texels are read; beyond twice that only cell means are."""
REACH = np.float32(1.5)
"""Half depth, in texels, of the range whose layers measure the distance between strands."""
CROWDED = np.float32(0.1)
"""Relative increase of τ for each unit of (width / distance between strands)² τ, as measured in bundles."""


def stride_for(layers: int) -> int:
    """Return the numbers of a row."""
    return TEXELS * (layers + 1)


def numbers_of(cells: int, rows: int, layers: int) -> int:
    """Return the length of a map with so many cells and, besides the empty row, so many rows."""
    return HEAD * cells + (rows + 1) * stride_for(layers)


@inlined
def layers_at(d, head, over, layers):
    """Return, for the depths d in rows with this head: layer index, position within the layer (0 to 1), number of
    layers that end in front (may exceed `layers`), and layers a metre. Vectors; over: 1 / h, 1/m."""
    front, most = head[START], head[SCALE]
    far = max(ZERO, (d - front) * over)
    near = ONE / (far + ONE)
    gone = most * (far * near)
    ended = min(np.float32(layers), gone)
    k = min(np.float32(layers - 1), floor(ended))
    return k, ended - k, floor(gone), most * over * near * near


@inlined
def mean(texels):
    """Return the mean of the four texels of cells."""
    return HALF * HALF * ((texels[0] + texels[1]) + (texels[2] + texels[3]))


@inlined
def growth_at(rows, start, number, k, dense, reach, layers):
    """Return the mean growth of a cell's τ, 1/m, over layer k and the layers within `reach` metres of it; 0 where the
    depth is farther than that behind the last layer. dense: layers a metre. Vectors."""
    stride = TEXELS * (layers + 1)
    most = np.float32(layers)
    aside = floor(min(most, max(ZERO, reach * dense)))
    first = min(most, max(ZERO, k - aside))
    last = min(most, k + aside + ONE)
    low = mean(gather4(rows, start, number, stride, EACH * first))
    high = mean(gather4(rows, start, number, stride, EACH * last))
    return (high - low) * dense / max(last - first, ONE)


@inlined
def in_front(u, v, d, scale, rows, start, size, over, layers, behind):
    """Return τ in front of points, interpolated between texels and between cell means, and the latter's growth, 1/m;
    and τ of all strands, between texels, but the same again where `behind` is None. u, v: column and row, integers at
    texel centres; d: depth, metres; scale: texels a metre there; start: first index of the map; over: 1 / h, 1/m.
    Vectors; rows: `pointer` to the maps."""
    half = size >> 1
    last = np.float32(half - 2)
    wide_u = HALF * (u - HALF)
    wide_v = HALF * (v - HALF)
    left = min(last, max(ZERO, floor(wide_u)))
    up = min(last, max(ZERO, floor(wide_v)))
    wide_u = min(max(wide_u - left, ZERO), ONE)
    wide_v = min(max(wide_v - up, ZERO), ONE)
    point = d, over, REACH / scale
    a = cells_at(rows, start, half, up, left, point, layers)
    b = cells_at(rows, start, half, up, left + ONE, point, layers)
    c = cells_at(rows, start, half, up + ONE, left, point, layers)
    e = cells_at(rows, start, half, up + ONE, left + ONE, point, layers)
    column, row = floor(u), floor(v)
    right, low = column - (left + left), row - (up + up)  # of the first texel, from that of the first cell: 0, 1 or 2
    whole = texels = between(u - column, v - row, right, low, a.texels, b.texels, c.texels, e.texels)
    if behind is not None:
        whole = between(u - column, v - row, right, low, a.whole, b.whole, c.whole, e.whole)
    cells = bilinear(wide_u, wide_v, a.mean, b.mean, c.mean, e.mean)
    return texels, cells, bilinear(wide_u, wide_v, a.growth, b.growth, c.growth, e.growth), whole


class Cells(NamedTuple):
    """What lies in front of points in cells; vectors."""

    texels: Any
    """τ in front of the depth, in each of the four texels."""
    mean: Any
    """Of these."""
    growth: Any
    """Of the mean, 1/m."""
    whole: Any
    """τ of all strands, in each texel."""


@inlined
def cells_at(rows, start, half, up, left, point, layers):
    """Return the `Cells` in rows `up` and columns `left`; point: depth, metres, 1 / h, 1/m, and half the depth over
    which growth is measured, metres; the rest as in `in_front`."""
    d, over, reach = point
    body = start + HEAD * half * half
    head = gather8(rows, start, up, HEAD * half, np.float32(HEAD) * left)
    k, part, gone, dense = layers_at(d, head, over, layers)
    p, q, r, s, p_end, q_end, r_end, s_end = gather8(rows, body, head[ROW], TEXELS * (layers + 1), EACH * k)
    texels = p + part * (p_end - p), q + part * (q_end - q), r + part * (r_end - r), s + part * (s_end - s)
    low, high = mean((p, q, r, s)), mean((p_end, q_end, r_end, s_end))
    if any_lane(reach * dense >= ONE):
        growth = growth_at(rows, body, head[ROW], gone, dense, reach, layers)
    else:  # no layer but that of the point is within reach
        growth = where(gone < np.float32(layers), (high - low) * dense, ZERO)
    return Cells(texels, low + part * (high - low), growth, head[WHOLE:])


@inlined
def between(u, v, right, low, a, b, c, e):
    """Interpolate between the texels of four cells, four numbers each, from those in column `right` and row `low` on,
    0 to 2. Vectors."""
    first, second = beside(right, a, b)
    third, fourth = beside(right, c, e)
    return bilinear(
        u, v,
        among(low, first[0], second[0], third[0]), among(low, first[1], second[1], third[1]),
        among(low, second[0], third[0], fourth[0]), among(low, second[1], third[1], fourth[1]),
    )  # fmt: skip


@inlined
def beside(right, a, b):
    """Return, of the upper and of the lower row of texels of two cells beside each other, those in column `right`, 0 to
    2, and in the one after it. Vectors."""
    return (
        (among(right, a[0], a[1], b[0]), among(right, a[1], b[0], b[1])),
        (among(right, a[2], a[3], b[2]), among(right, a[3], b[2], b[3])),
    )


@inlined
def among(number, a, b, c):
    """Return a, b or c: number 0, 1 or 2. Vectors."""
    return where(number > ONE, c, where(number > ZERO, b, a))


@device
def corrected_depth(texels, cells, growth, width, scale):
    """Return τ from the three results of `in_front`: the blend of both, minus the strand's own contribution, with the
    correction for crowded strands. width: of strands, metres; scale: texels a metre at that depth."""
    apart = math.sqrt(width / max(growth, TINY)) * scale
    share = min(max(apart * (ONE / CLOSE) - ONE, ZERO), ONE)
    own = OWN * width * scale * (ONE - HALF * share)
    depth = max(texels + share * (cells - texels) - own, ZERO)
    return depth * (ONE + CROWDED * min(width * growth, ONE) * depth)
