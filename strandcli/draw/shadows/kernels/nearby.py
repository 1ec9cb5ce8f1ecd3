"""Strands that hardly any light reaches, by opacity maps (`strandcli.draw.shadows.nearby`)."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined, parallel, prange
from ...common.kernels.light_columns import BIAS, FIRST_MAP, MAP_COUNT, MAP_LAYERS, PER_FALL
from . import opacity
from .minmax import in_map, texel_of

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
ONE_ON, TWO_ON, THREE_ON = np.uint64(1), np.uint64(2), np.uint64(3)


@parallel
def depths(world, lights, i, shadows, out):
    """Write the optical depth between light number i and each vertex of world (V, 3), metres, to out (V,): that of the
    vertex's cell. lights (n, `light_columns.COLUMNS`); shadows: `ShadowArrays`."""
    for v in prange(world.shape[0]):
        out[v] = depth_of_cell(world[v, 0], world[v, 1], world[v, 2], lights, i, shadows)


@device
def depth_of_cell(x, y, z, lights, i, shadows):
    """Return the optical depth in front of a point in the cell that it is in; 0 outside of the maps and where no strand
    is."""
    layers = np.int64(lights[i, MAP_LAYERS])
    for one in range(int(lights[i, FIRST_MAP]), int(lights[i, FIRST_MAP] + lights[i, MAP_COUNT])):
        size = shadows.sizes[one]
        u, v, d = texel_of(x, y, z, shadows.views, one)
        if not in_map(u, v, d, shadows.views, one, np.float32(size - 1)):
            continue
        start, stacks = np.uint64(shadows.starts[one]), shadows.stacks
        head = opacity.head_at(np.int64(v), np.int64(u), start, size)
        if np.int32(stacks[head + np.uint64(opacity.ROW)]) == 0:
            return ZERO
        row = opacity.cell_of(np.int64(v), np.int64(u), start, size, layers, stacks)
        far = max(d - lights[i, BIAS] - stacks[head + np.uint64(opacity.START)], ZERO) * lights[i, PER_FALL]
        ended = min(stacks[head + np.uint64(opacity.SCALE)] * (far / (far + ONE)), np.float32(layers))
        layer = min(np.int64(ended), layers - 1)
        at = row + np.uint64(opacity.TEXELS * layer)
        low, high = mean_at(stacks, at), mean_at(stacks, at + np.uint64(opacity.TEXELS))
        return low + (ended - np.float32(layer)) * (high - low)
    return ZERO


@inlined
def mean_at(stacks, at):
    """Return the mean of the four texels at a layer boundary."""
    return opacity.mean((stacks[at], stacks[at + ONE_ON], stacks[at + TWO_ON], stacks[at + THREE_ON]))


@parallel
def bury(first, depth, limit, out):
    """Write 1 to out (V,) uint8 at the vertices that lie, with those before and after them on their strand, behind an
    optical depth of `limit`, and 0 at the others. first (S + 1,): vertex offsets; depth (V,): from `depths`."""
    for s in prange(first.shape[0] - 1):
        for v in range(first[s], first[s + 1]):
            before = max(v - 1, first[s])
            after = min(v + 1, first[s + 1] - 1)
            out[v] = (depth[before] > limit) & (depth[v] > limit) & (depth[after] > limit)
