"""What strands leave of a light at a batch of vertices, by min/max maps or by opacity maps."""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import inner
from . import opacity
from .batch import ARRIVES, DEPTH, INSIDE, LEFT, PASSED, TEXELS, U, V, X, Y, Z
from .shadow import between, held, texel_of, through

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
NEXT = np.uint64(1)


@inner
def shade(work, n, views, one, maps, start, size, bias):
    """What strands leave of a light, by one map: only where no map before held the vertex."""
    if size < 2:
        return
    locate(work, n, views, one, size, bias)
    for k in range(n):
        texel = np.uint64(start + np.int64(work[V + k]) * size + np.int64(work[U + k]))
        below = texel + np.uint64(size)
        work[TEXELS + k] = maps[texel, 0]
        work[TEXELS + W + k] = maps[texel, 1]
        work[TEXELS + 2 * W + k] = maps[texel + NEXT, 0]
        work[TEXELS + 3 * W + k] = maps[texel + NEXT, 1]
        work[TEXELS + 4 * W + k] = maps[below, 0]
        work[TEXELS + 5 * W + k] = maps[below, 1]
        work[TEXELS + 6 * W + k] = maps[below + NEXT, 0]
        work[TEXELS + 7 * W + k] = maps[below + NEXT, 1]
    for k in range(n):
        d = work[DEPTH + k]
        left = between(
            work[U + k] - np.floor(work[U + k]),
            work[V + k] - np.floor(work[V + k]),
            through(d, work[TEXELS + k], work[TEXELS + W + k]),
            through(d, work[TEXELS + 2 * W + k], work[TEXELS + 3 * W + k]),
            through(d, work[TEXELS + 4 * W + k], work[TEXELS + 5 * W + k]),
            through(d, work[TEXELS + 6 * W + k], work[TEXELS + 7 * W + k]),
        )
        work[ARRIVES + k] *= left if work[INSIDE + k] > ZERO else ONE


@inner
def locate(work, n, views, one, size, bias):
    """Where a map shows the vertices that no map before held."""
    edge = np.float32(size - 1)
    for k in range(n):
        u, v, d = texel_of(work[X + k], work[Y + k], work[Z + k], views, one)
        fresh = held(u, v, d, views, one, edge) & (work[INSIDE + k] == ZERO)
        work[U + k] = u if fresh else ZERO
        work[V + k] = v if fresh else ZERO
        work[DEPTH + k] = d - bias if fresh else -ONE
        work[INSIDE + k] = ONE if fresh else -work[INSIDE + k] * work[INSIDE + k]  # −1: by a map before


@inner
def mixed(work, k):
    """Between the four texels around vertex k."""
    return between(
        work[U + k] - np.floor(work[U + k]),
        work[V + k] - np.floor(work[V + k]),
        work[TEXELS + k],
        work[TEXELS + W + k],
        work[TEXELS + 2 * W + k],
        work[TEXELS + 3 * W + k],
    )


@inner
def sink(work, n, views, one, stacks, layers, start, size, bias):
    """Strands between the light and each vertex, by one opacity map: as `shade`."""
    if size < 2:
        return
    locate(work, n, views, one, size, bias)
    stride = np.uint64(layers + opacity.HEAD + 1)
    down = np.uint64(size) * stride
    for k in range(n):
        place = np.int64(work[V + k]) * size + np.int64(work[U + k])
        texel = np.uint64(start) + np.uint64(place) * stride
        d = work[DEPTH + k]
        work[TEXELS + k] = opacity.depth_at(d, texel, layers, stacks)
        work[TEXELS + W + k] = opacity.depth_at(d, texel + stride, layers, stacks)
        work[TEXELS + 2 * W + k] = opacity.depth_at(d, texel + down, layers, stacks)
        work[TEXELS + 3 * W + k] = opacity.depth_at(d, texel + down + stride, layers, stacks)
    for k in range(n):
        passed = mixed(work, k)
        work[PASSED + k] += passed if work[INSIDE + k] > ZERO else ZERO


@inner
def beyond(work, n, stacks, layers, start, size):
    """Strands behind each vertex, where `sink` has just found those in front of it."""
    if size < 2:
        return
    stride = np.uint64(layers + opacity.HEAD + 1)
    down = np.uint64(size) * stride
    for k in range(n):
        place = np.int64(work[V + k]) * size + np.int64(work[U + k])
        last = np.uint64(start) + np.uint64(place + 1) * stride - NEXT
        work[TEXELS + k] = stacks[last]
        work[TEXELS + W + k] = stacks[last + stride]
        work[TEXELS + 2 * W + k] = stacks[last + down]
        work[TEXELS + 3 * W + k] = stacks[last + down + stride]
    for k in range(n):
        total = mixed(work, k)
        work[LEFT + k] += max(total - work[PASSED + k], ZERO) if work[INSIDE + k] > ZERO else ZERO
