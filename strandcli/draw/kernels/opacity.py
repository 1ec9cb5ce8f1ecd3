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

from ...jit import function, inlined, inner
from .approximations import exp
from .shadow import between, held, texel_of

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
def layer_at(d, base, over, layers, stacks):
    """Where the row that begins at `base` (uint64) keeps what begins the layer of depth d, how much of τ in the layer
    is in front, how many layers have ended, beyond the last too, and how many there are a metre."""
    far = max((d - stacks[base]) * over, ZERO)
    near = ONE / (far + ONE)
    gone = stacks[base + np.uint64(1)] * (far * near)
    ended = min(gone, np.float32(layers))
    k = min(np.int64(ended), layers - 1)
    dense = stacks[base + np.uint64(1)] * over * near * near
    return base + np.uint64(HEAD + FIVE * k), ended - np.float32(k), np.int64(gone), dense


@inlined
def within(at, part, which, stacks):
    """Of one of a cell's five, τ in front of a depth, of which `layer_at` tells where it is."""
    low = stacks[at + np.uint64(which)]
    return low + part * (stacks[at + np.uint64(which + FIVE)] - low)


@inlined
def growth_at(base, k, dense, reach, layers, stacks):
    """By how much the mean τ of a cell grows a metre, in the layer after k and those that `reach` metres hold to each
    side of it, where there are so many layers a metre; 0 where none is so near."""
    aside = np.int64(min(max(reach * dense, ZERO), np.float32(layers)))
    first = min(max(k - aside, 0), layers)
    last = min(k + aside + 1, layers)
    mean = base + np.uint64(HEAD + TEXELS)
    grown = stacks[mean + np.uint64(FIVE * last)] - stacks[mean + np.uint64(FIVE * first)]
    return grown * dense / np.float32(max(last - first, 1))


@inner
def depth_at(d, row, column, start, size, over, layers, stacks):
    """τ in front of depth d in a texel of the map that begins at `start` (uint64)."""
    at, part, _, _ = layer_at(d, cell_of(row, column, start, size, layers, stacks), over, layers, stacks)
    return within(at, part, 2 * (row & 1) + (column & 1), stacks)


@inlined
def one_of(lower, right, a, b, c, d):
    """Of a square's four."""
    return (d if right else c) if lower else (b if right else a)


@inner
def in_front(u, v, d, scale, start, size, over, layers, stacks):
    """τ in front of a place of a map, column and row, whole at the texels' middles, and depth: by the texels about it,
    by the cells about it, of which these texels are some, and what the latter grows by a metre; scale: texels a metre
    there."""
    half = size >> 1
    wide_u = HALF * (u - HALF)
    wide_v = HALF * (v - HALF)
    left = min(max(np.int64(np.floor(wide_u)), 0), half - 2)
    up = min(max(np.int64(np.floor(wide_v)), 0), half - 2)
    wide_u = min(max(wide_u - np.float32(left), ZERO), ONE)
    wide_v = min(max(wide_v - np.float32(up), ZERO), ONE)
    a = cell_of(2 * up, 2 * left, start, size, layers, stacks)
    b = cell_of(2 * up, 2 * left + 2, start, size, layers, stacks)
    c = cell_of(2 * up + 2, 2 * left, start, size, layers, stacks)
    e = cell_of(2 * up + 2, 2 * left + 2, start, size, layers, stacks)
    reach = REACH / scale
    at_a, part_a, k_a, dense_a = layer_at(d, a, over, layers, stacks)
    at_b, part_b, k_b, dense_b = layer_at(d, b, over, layers, stacks)
    at_c, part_c, k_c, dense_c = layer_at(d, c, over, layers, stacks)
    at_e, part_e, k_e, dense_e = layer_at(d, e, over, layers, stacks)
    cells = between(
        wide_u, wide_v,
        within(at_a, part_a, TEXELS, stacks), within(at_b, part_b, TEXELS, stacks),
        within(at_c, part_c, TEXELS, stacks), within(at_e, part_e, TEXELS, stacks),
    )  # fmt: skip
    growth = between(
        wide_u, wide_v,
        growth_at(a, k_a, dense_a, reach, layers, stacks), growth_at(b, k_b, dense_b, reach, layers, stacks),
        growth_at(c, k_c, dense_c, reach, layers, stacks), growth_at(e, k_e, dense_e, reach, layers, stacks),
    )  # fmt: skip
    low_u = np.floor(u)
    low_v = np.floor(v)
    column = np.int64(low_u)
    row = np.int64(low_v)
    first = column >> 1 > left
    last = (column + 1) >> 1 > left
    upper = row >> 1 > up
    lower = (row + 1) >> 1 > up
    here = 2 * (row & 1) + (column & 1)
    texels = between(
        u - low_u, v - low_v,
        within(one_of(upper, first, at_a, at_b, at_c, at_e), one_of(upper, first, part_a, part_b, part_c, part_e),
               here, stacks),
        within(one_of(upper, last, at_a, at_b, at_c, at_e), one_of(upper, last, part_a, part_b, part_c, part_e),
               here ^ 1, stacks),
        within(one_of(lower, first, at_a, at_b, at_c, at_e), one_of(lower, first, part_a, part_b, part_c, part_e),
               here ^ 2, stacks),
        within(one_of(lower, last, at_a, at_b, at_c, at_e), one_of(lower, last, part_a, part_b, part_c, part_e),
               here ^ 3, stacks),
    )  # fmt: skip
    return texels, cells, growth


@inner
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


@inner
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

    As `shadow.transmittance`; width: mean one of strands, metres, or 0 for a point that is on none; lights [10]:
    layers, [14]: 1 / h; starts: where a map begins in stacks.
    """
    layers = np.int64(lights[i, 10])
    for one in range(int(lights[i, 7]), int(lights[i, 7] + lights[i, 8])):
        u, v, d = texel_of(x, y, z, views, one)
        if not held(u, v, d, views, one, np.float32(sizes[one] - 1)):
            continue
        scale = views[one, 13] / d if views[one, 12] > ZERO else views[one, 13]
        d -= lights[i, 9]
        start, size = np.uint64(starts[one]), np.int64(sizes[one])
        texels, cells, growth = in_front(u, v, d, scale, start, size, lights[i, 14], layers, stacks)
        return settled(texels, cells, growth, width, scale)
    return ZERO


@function
def transmittance(x, y, z, width, lights, i, stacks, starts, sizes, views):
    """Share of light that reaches a point: e^-τ."""
    return exp(-optical_depth(x, y, z, width, lights, i, stacks, starts, sizes, views))
