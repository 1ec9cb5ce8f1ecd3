"""Deep opacity maps (Yuksel & Keyser 2008): how many strands a ray of light meets, texel by texel and layer by layer.

Layers divide the depths from the nearest strand about a texel to the farthest, so that of n, x metres behind the
nearest, n (x / (x + h)) (1 + h / D) have ended, where D is how far the farthest is. Where light falls off, within a few
times the length h, they are nearly even, and only what is dark anyhow shares the others. In each is gathered projected
length × width / texel area of the strands' pieces, between the four texels that each lies between: the mean number of
strands that a ray meets there, its optical depth τ. What is left of the light is e^-τ where the strands' places are
independent. Where they are crowded strands keep out of each other's places and cover more than that: τ is taken to be
larger by a part of itself that grows with τ and with (width / distance between strands)².

Four texels, a cell, have their layers at the same depths, so that their mean is one texel twice as wide. Where strands
lie far apart, by what the layers about a point hold, that is read instead, and a mixture in between: an estimate of
density with a window as wide as it takes. The layers asked about that are as deep together as a window is wide, for
thin ones hold a strand or none. A strand's own share of what lies in front of it, half of what it leaves in
the window's middle, is taken off.

A cell that a strand comes to is a row of numbers: nearest depth, n (1 + h / D), and then, for the ends of the layers
from the nearest depth on, the τ in front of them: five numbers, of the four texels and their mean. Within a layer τ is
linear. A map is one flat array: a table, for each cell the number of its row, and the rows. All cells that no strand
comes to, nine tenths of a ponytail's map, share row 0.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, function, inlined
from ....simd import broadcast, floor, gather, pointer, reduce_max, where
from ...common.kernels.approximations import exp
from ...common.kernels.light_columns import BIAS, FIRST_MAP, MAP_COUNT, MAP_LAYERS, PER_FALL
from ...common.kernels.view_columns import FOCAL, PERSPECTIVE
from .minmax import between, held, texel_of

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
HEAD = 2
"""Numbers of a row before its layers."""
TEXELS = 4
"""Of a cell."""
FIVE = 5
"""Numbers of the end of a layer: each texel's, and their mean."""
OWN = np.float32(0.375)
"""Half of what a strand as wide as a texel leaves in the middle of a quadratic spline about it."""
BEGIN, NEXT = np.float32(HEAD), np.float32(HEAD + FIVE)
"""Where the ends of a row's first and second layer are,"""
EACH, MEAN = np.float32(FIVE), np.float32(TEXELS)
"""how far from each other, and which of the five is the mean."""
CLOSE = np.float32(0.8)
"""Texels that strands are apart, by the layers, up to which texels are read, and beyond twice as many cells' means."""
REACH = np.float32(1.5)
"""Texels to each side, in depth, over which layers are asked how far apart strands are."""
CROWDED = np.float32(0.1)
"""Of (width / distance between strands)² τ, the part that τ grows by: as measured in bundles."""


def stride_for(layers: int) -> int:
    """Numbers of a row."""
    return HEAD + FIVE * (layers + 1)


def numbers_of(cells: int, rows: int, layers: int) -> int:
    """Of a map with so many rows besides the empty one."""
    return cells + (rows + 1) * stride_for(layers)


@inlined
def cell_of(row, column, start, size, layers, stacks):
    """Where the row of a texel's cell begins, in the map that begins at `start` (uint64)."""
    half = size >> 1
    cell = np.uint64((row >> 1) * half + (column >> 1))
    number = np.uint64(np.int32(stacks[start + cell]))
    return start + np.uint64(half * half) + number * np.uint64(HEAD + FIVE * (layers + 1))


@inlined
def layers_at(d, rows, start, number, over, layers):
    """Of the rows of these numbers, in the map that begins at `start`, the layers of depths d, how much of τ in the
    layer is in front, how many layers have ended, beyond the last too, and how many there are a metre. Vectors, as
    `number`; rows: `pointer` to the maps."""
    stride = HEAD + FIVE * (layers + 1)
    far = max(ZERO, (d - gather(rows, start, number, stride, ZERO)) * over)
    near = ONE / (far + ONE)
    most = gather(rows, start, number, stride, ONE)
    gone = most * (far * near)
    ended = min(np.float32(layers), gone)
    k = min(np.float32(layers - 1), floor(ended))
    return k, ended - k, floor(gone), most * over * near * near


@inlined
def within(rows, start, number, k, part, which, layers):
    """Of one of a cell's five, τ in front of depths, of which `layers_at` tells where they are."""
    stride = HEAD + FIVE * (layers + 1)
    low = gather(rows, start, number, stride, BEGIN + EACH * k + which)
    high = gather(rows, start, number, stride, NEXT + EACH * k + which)
    return low + part * (high - low)


@inlined
def growth_at(rows, start, number, k, dense, reach, layers):
    """By how much the mean τ of cells grows a metre, in the layers after k and those that `reach` metres hold to each
    side of them, where there are so many layers a metre; 0 where none is so near."""
    stride = HEAD + FIVE * (layers + 1)
    most = np.float32(layers)
    aside = floor(min(most, max(ZERO, reach * dense)))
    first = min(most, max(ZERO, k - aside))
    last = min(most, k + aside + ONE)
    low = gather(rows, start, number, stride, BEGIN + MEAN + EACH * first)
    high = gather(rows, start, number, stride, BEGIN + MEAN + EACH * last)
    return (high - low) * dense / max(last - first, ONE)


@inlined
def one_of(lower, right, a, b, c, d):
    """Of squares' four."""
    return where(lower, where(right, d, c), where(right, b, a))


@inlined
def in_front(u, v, d, scale, rows, start, size, over, layers):
    """τ in front of places of the map that begins at `start`, column and row, whole at the texels' middles, and depth:
    by the texels about them, by the cells about them, of which these texels are some, and what the latter grows by a
    metre; scale: texels a metre there. Vectors; rows: `pointer` to the maps."""
    half = size >> 1
    last = np.float32(half - 2)
    body = start + half * half
    wide_u = HALF * (u - HALF)
    wide_v = HALF * (v - HALF)
    left = min(last, max(ZERO, floor(wide_u)))
    up = min(last, max(ZERO, floor(wide_v)))
    wide_u = min(max(wide_u - left, ZERO), ONE)
    wide_v = min(max(wide_v - up, ZERO), ONE)
    a = gather(rows, start, up, half, left)
    b = gather(rows, start, up, half, left + ONE)
    c = gather(rows, start, up + ONE, half, left)
    e = gather(rows, start, up + ONE, half, left + ONE)
    reach = REACH / scale
    k_a, part_a, gone_a, dense_a = layers_at(d, rows, body, a, over, layers)
    k_b, part_b, gone_b, dense_b = layers_at(d, rows, body, b, over, layers)
    k_c, part_c, gone_c, dense_c = layers_at(d, rows, body, c, over, layers)
    k_e, part_e, gone_e, dense_e = layers_at(d, rows, body, e, over, layers)
    cells = between(
        wide_u, wide_v,
        within(rows, body, a, k_a, part_a, MEAN, layers), within(rows, body, b, k_b, part_b, MEAN, layers),
        within(rows, body, c, k_c, part_c, MEAN, layers), within(rows, body, e, k_e, part_e, MEAN, layers),
    )  # fmt: skip
    growth = between(
        wide_u, wide_v,
        growth_at(rows, body, a, gone_a, dense_a, reach, layers),
        growth_at(rows, body, b, gone_b, dense_b, reach, layers),
        growth_at(rows, body, c, gone_c, dense_c, reach, layers),
        growth_at(rows, body, e, gone_e, dense_e, reach, layers),
    )  # fmt: skip
    column = floor(u)
    row = floor(v)
    first = floor(HALF * column)
    upper = floor(HALF * row)
    right = column - (first + first)  # 1 where it is odd
    low = row - (upper + upper)
    here = low + low + right
    beside = low + low + (ONE - right)
    below = (ONE - low) + (ONE - low)
    across = first + right > left
    first = first > left
    lower = upper + low > up
    upper = upper > up
    texels = between(
        u - column, v - row,
        within(rows, body, one_of(upper, first, a, b, c, e), one_of(upper, first, k_a, k_b, k_c, k_e),
               one_of(upper, first, part_a, part_b, part_c, part_e), here, layers),
        within(rows, body, one_of(upper, across, a, b, c, e), one_of(upper, across, k_a, k_b, k_c, k_e),
               one_of(upper, across, part_a, part_b, part_c, part_e), beside, layers),
        within(rows, body, one_of(lower, first, a, b, c, e), one_of(lower, first, k_a, k_b, k_c, k_e),
               one_of(lower, first, part_a, part_b, part_c, part_e), below + right, layers),
        within(rows, body, one_of(lower, across, a, b, c, e), one_of(lower, across, k_a, k_b, k_c, k_e),
               one_of(lower, across, part_a, part_b, part_c, part_e), below + (ONE - right), layers),
    )  # fmt: skip
    return texels, cells, growth


@device
def through(u, v, start, size, layers, stacks):
    """τ of all strands at a place of a map."""
    low_u = np.floor(u)
    low_v = np.floor(v)
    column = np.int64(low_u)
    row = np.int64(low_v)
    here = 2 * (row & 1) + (column & 1)
    end = np.uint64(HEAD + FIVE * layers)
    return between(
        u - low_u, v - low_v,
        stacks[cell_of(row, column, start, size, layers, stacks) + end + np.uint64(here)],
        stacks[cell_of(row, column + 1, start, size, layers, stacks) + end + np.uint64(here ^ 1)],
        stacks[cell_of(row + 1, column, start, size, layers, stacks) + end + np.uint64(here ^ 2)],
        stacks[cell_of(row + 1, column + 1, start, size, layers, stacks) + end + np.uint64(here ^ 3)],
    )  # fmt: skip


@device
def settled(texels, cells, growth, width, scale):
    """Which of both, in which mixture, less the strand's own share, and more where strands are crowded; width: of
    strands, metres; scale: texels a metre there."""
    apart = math.sqrt(width / max(growth, TINY)) * scale
    share = min(max(apart * (ONE / CLOSE) - ONE, ZERO), ONE)
    own = OWN * width * scale * (ONE - HALF * share)
    depth = max(texels + share * (cells - texels) - own, ZERO)
    return depth * (ONE + CROWDED * min(width * growth, ONE) * depth)


@function
def optical_depth(x, y, z, width, lights, i, stacks, starts, sizes, views):
    """τ between a light and a point; 0 where no map of the light holds the point.

    As `minmax.transmittance`; width: mean one of strands, metres, or 0 for a point that is on none; stacks, starts,
    sizes, views: of `ShadowArrays`.
    """
    layers = np.int64(lights[i, MAP_LAYERS])
    for one in range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT])):
        u, v, d = texel_of(x, y, z, views, one)
        if not held(u, v, d, views, one, np.float32(sizes[one] - 1)):
            continue
        scale = views[one, FOCAL] / d if views[one, PERSPECTIVE] > ZERO else views[one, FOCAL]
        d -= lights[i, BIAS]
        rows = pointer(stacks)
        texels, cells, growth = in_front(
            broadcast(rows, u), broadcast(rows, v), broadcast(rows, d), broadcast(rows, scale), rows, starts[one],
            sizes[one],
            lights[i, PER_FALL], layers,
        )  # fmt: skip
        return settled(reduce_max(texels), reduce_max(cells), reduce_max(growth), width, scale)
    return ZERO


@function
def transmittance(x, y, z, width, lights, i, stacks, starts, sizes, views):
    """Share of light that reaches a point: e^-τ."""
    return exp(-optical_depth(x, y, z, width, lights, i, stacks, starts, sizes, views))
