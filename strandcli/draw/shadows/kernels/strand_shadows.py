"""Shadows of strands at a batch of vertices, from min/max maps or opacity maps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import W
from ....jit import device, function
from ....simd import broadcast, load, pointer, store, store3
from ....simd import lane_count as lanes
from ...common.kernels.batch import ARRIVES, DEPTH, INSIDE, LEFT, PASSED, TEXELS, U, V, X, vector_at
from ...common.kernels.numbers import ONE, ZERO
from ...common.kernels.view_columns import FOCAL, NEAR_PLANE, PERSPECTIVE
from . import opacity
from .minmax import FARTHEST, NEAREST, bilinear, falloff, texel_of


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


NEXT = np.uint64(1)
TWICE = np.float32(2.0)


@function
def shade_by_minmax(work, n, shadows, one, bias):
    """Multiply the rows `ARRIVES` of the first n vertices of a batch by the transmittance in min/max map number `one`
    of `ShadowArrays`, for vertices that no earlier map contains. bias: metres.

    x = (d − r) / (a − r) (the source prints its inverse), y = (eˣ − 1) / (e − 1), transmittance 1 − y (thesis §3),
    interpolated bilinearly between four texels."""
    maps, start, size, views = shadows.texels, shadows.starts[one], shadows.sizes[one], shadows.views
    if size < 2:
        return
    locate(work, n, views, one, size, bias)
    for k in range(n):
        texel = np.uint64(start + np.int64(work[V + k]) * size + np.int64(work[U + k]))
        below = texel + np.uint64(size)
        work[TEXELS + k] = maps[texel, NEAREST]
        work[TEXELS + W + k] = maps[texel, FARTHEST]
        work[TEXELS + 2 * W + k] = maps[texel + NEXT, NEAREST]
        work[TEXELS + 3 * W + k] = maps[texel + NEXT, FARTHEST]
        work[TEXELS + 4 * W + k] = maps[below, NEAREST]
        work[TEXELS + 5 * W + k] = maps[below, FARTHEST]
        work[TEXELS + 6 * W + k] = maps[below + NEXT, NEAREST]
        work[TEXELS + 7 * W + k] = maps[below + NEXT, FARTHEST]
    for k in range(n):
        d = work[DEPTH + k]
        left = bilinear(
            work[U + k] - np.floor(work[U + k]),
            work[V + k] - np.floor(work[V + k]),
            falloff(d, work[TEXELS + k], work[TEXELS + W + k]),
            falloff(d, work[TEXELS + 2 * W + k], work[TEXELS + 3 * W + k]),
            falloff(d, work[TEXELS + 4 * W + k], work[TEXELS + 5 * W + k]),
            falloff(d, work[TEXELS + 6 * W + k], work[TEXELS + 7 * W + k]),
        )
        farthest = max(
            max(work[TEXELS + W + k], work[TEXELS + 3 * W + k]), max(work[TEXELS + 5 * W + k], work[TEXELS + 7 * W + k])
        )
        shaded = (work[INSIDE + k] > ZERO) & (farthest >= ZERO)  # less than 0: no strand in any of the four
        work[ARRIVES + k] *= left if shaded else ONE


@device
def locate(work, n, views, one, size, bias):
    """Project the vertices that no earlier map contains into map number `one`, `size` texels a side: rows `U`, `V`
    (texels), `DEPTH` (metres, minus the bias), and `INSIDE`: 1 if this map contains the vertex, −1 if an earlier one
    does, else 0."""
    edge = np.float32(size - 1)
    for k in range(n):
        u, v, d = texel_of(vector_at(work, X, k), views, one)
        # between four texels; the outermost ones are empty, so points beyond them are lit
        inside = (d >= views[one, NEAR_PLANE]) & (u >= ZERO) & (v >= ZERO) & (u < edge) & (v < edge)
        fresh = inside & (work[INSIDE + k] == ZERO)
        work[U + k] = u if fresh else ZERO
        work[V + k] = v if fresh else ZERO
        work[DEPTH + k] = d - bias if fresh else -ONE
        work[INSIDE + k] = ONE if fresh else -work[INSIDE + k] * work[INSIDE + k]


@device
def count_in_front(work, n, shadows, one, layers, bias, width, over, behind):
    """Add the optical depth between the light and each of the first n vertices to the rows `PASSED`, from opacity map
    number `one` of `ShadowArrays`, for vertices that no earlier map contains.

    bias: metres; width: mean width of strands, metres; over: 1 / h of `opacity`, 1/m; behind: None, or that
    of the strands behind is added to the rows `LEFT`, too.
    """
    stacks, start, size, views = shadows.stacks, shadows.starts[one], shadows.sizes[one], shadows.views
    if size < 2:
        return
    locate(work, n, views, one, size, bias)
    rows, maps = pointer(work), pointer(stacks)
    for k in range(n, W):  # the unused lanes of the last vector must read valid texels
        work[U + k] = work[V + k] = work[DEPTH + k] = ZERO
    near = views[one, PERSPECTIVE] > ZERO
    for k in range(0, n, lanes(rows)):
        depth = load(rows, DEPTH + k)
        scale = broadcast(rows, views[one, FOCAL])
        if near:
            scale = scale / (depth + bias)
        texels, cells, growth, whole = opacity.in_front(
            load(rows, U + k), load(rows, V + k), depth, scale, maps, start, size, over, layers, behind
        )
        if behind is not None:
            store(rows, TEXELS + 3 * W + k, whole)
        store3(rows, TEXELS + k, W, texels, cells, growth)
    for k in range(n):
        scale = views[one, FOCAL] / (work[DEPTH + k] + bias) if near else views[one, FOCAL]
        texels, cells, growth = work[TEXELS + k], work[TEXELS + W + k], work[TEXELS + 2 * W + k]
        passed = opacity.corrected_depth(texels, cells, growth, width, scale)
        inside = work[INSIDE + k] > ZERO
        work[PASSED + k] += passed if inside else ZERO
        if behind is not None:
            total = max(work[TEXELS + 3 * W + k] - TWICE * opacity.OWN * width * scale - work[PASSED + k], ZERO)
            work[LEFT + k] += total if inside else ZERO
