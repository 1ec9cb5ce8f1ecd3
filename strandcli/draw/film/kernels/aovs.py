"""Layers beside the picture that kernels find: the strands of sorted fragments, and shadows."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange
from ...common.kernels.batch import ARRIVES, ROWS, X, set_vector
from ...common.kernels.keys import LOW, SHIFT
from ...common.kernels.light_columns import POWER_B, POWER_G, POWER_R
from ...common.kernels.numbers import ONE, ZERO
from ...coverage.kernels.resolve import OPAQUE
from ...coverage.kernels.tiles import PIXELS, TILE_WIDTH, between, tile_at
from ...lighting.kernels.light import aim
from ...lighting.kernels.shade_strands import past_solids, past_strands
from ...solids.kernels import rays

RED, GREEN, BLUE = np.float32(0.2126), np.float32(0.7152), np.float32(0.0722)
"""Shares of the luminance (Rec. 709)."""


@parallel
def front(fragments, vertices, screen, base, least, keys, mask):
    """Write the strand that contributes most to each pixel to a z-buffer of solids, where strands contribute enough.

    fragments: `tiles.Fragments`; vertices: number of vertices; screen (V, 3); base: number of the first in the keys;
    least: least share of light from strands; keys (height * width,) uint64; mask (height * width,) float32 out: share
    of light from strands.
    """
    for one in prange(fragments.begin.shape[0]):
        number = np.int64(one)
        o = fragments.begin[number]
        tile = tile_at(number, fragments)
        width, stride = fragments.width, fragments.stride
        counts, vertex, weight, along = fragments.counts, fragments.vertex, fragments.weight, fragments.along
        for p in range(PIXELS):
            if counts[number * PIXELS + p] == 0:
                continue
            x = tile.left + p % TILE_WIDTH
            y = tile.top + p // TILE_WIDTH
            total = ZERO
            strands_ = ZERO
            most = ZERO
            best = o
            end = o + np.int64(counts[number * PIXELS + p])
            for i in range(o, end):
                total += weight[i]
                if vertex[i] < vertices:
                    strands_ += weight[i]
                    if weight[i] > most:
                        most = weight[i]
                        best = i
            o = end
            share = strands_ / total if ONE - total < OPAQUE else strands_
            mask[y * width + x] = share
            if share >= least:
                v, t = between(np.int64(vertex[best]), along[best], stride)
                past = min(np.int64(t * np.float32(stride)), stride - 1)
                v += past
                t = t * np.float32(stride) - np.float32(past)
                q = max(screen[v, 2] + t * (screen[v + 1, 2] - screen[v, 2]), ZERO)
                depth = np.uint64(np.float32(q).view(np.uint32))
                keys[y * width + x] = ((LOW - depth) << SHIFT) | np.uint64(base + v)


@parallel
def sum_light(points, which, lights, bare, maps, solids, sums):
    """Write the luminance of all lights at points to sums (n, 2): past strands and solids, and without these.

    points (n, 3), metres; which (n,) int64: number of the solid that a point is on, −1 on a strand; lights, bare:
    `inputs.Lights` for points of strands, and for points of solids; maps: `ShadowArrays`; solids: `Solids`.
    """
    for task in prange((points.shape[0] + W - 1) // W):
        begin = np.int64(task) * W
        work, places, own = np.empty(ROWS * W, np.float32), np.empty(6 * W, np.float32), np.empty(W, np.int64)
        for solid in (False, True):
            n = np.int64(0)
            for i in range(begin, min(begin + W, points.shape[0])):
                if (which[i] >= 0) == solid:
                    own[n] = i
                    x, y, z = points[i, 0], points[i, 1], points[i, 2]
                    set_vector(places, 0, n, (x, y, z))
                    if solid:
                        nx, ny, nz = rays.normal(solids, which[i], x, y, z)
                        x, y, z = x + nx * bare.skin, y + ny * bare.skin, z + nz * bare.skin
                    set_vector(places, 3 * W, n, (x, y, z))
                    n += 1
            if n > 0:
                add_lights(work, n, places, own, bare if solid else lights, maps, solids, sums)


@device
def add_lights(work, n, places, own, lights, maps, solids, sums):
    """`sum_light` of n points; places (6 W,): the points, and where their shadow rays begin; own (W,): their numbers;
    work: rows of `batch`."""
    rows = lights.rows
    for k in range(n):
        sums[own[k], 0] = sums[own[k], 1] = ZERO
    for i in range(rows.shape[0]):
        power = RED * rows[i, POWER_R] + GREEN * rows[i, POWER_G] + BLUE * rows[i, POWER_B]
        for k in range(3 * W):
            work[X + k] = places[k]
        aim(work, n, rows, i)
        for k in range(n):
            sums[own[k], 1] += power * work[ARRIVES + k]
        for k in range(3 * W):
            work[X + k] = places[3 * W + k]
        past_solids(work, n, rows, i, solids, lights.skin, lights.sized)
        for k in range(3 * W):
            work[X + k] = places[k]
        past_strands(work, n, lights, i, maps, None)
        for k in range(n):
            sums[own[k], 0] += power * work[ARRIVES + k]
