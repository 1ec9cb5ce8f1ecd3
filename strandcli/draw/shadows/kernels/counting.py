"""Counts of what strands draw into a shadow map; the maps themselves do not change."""

from __future__ import annotations

import numpy as np

from ....jit import device, parallel, prange
from ...common.kernels.numbers import HALF, ONE, ZERO
from .map_parts import AT, COUNT, DEPTH, TINY, WIDE, X, Y
from .map_segments import FINEST, PER_TEXEL


@parallel
def count_splats(parts, size, view, counts):
    """Write to counts (P,) int64 how many splats each part adds to an opacity map: one for each texel,
    of which `opacity_maps` adds two at once.

    parts: `PartsInMap`; size: texels along a side; view: `MapView`.
    """
    for k in prange(counts.shape[0]):
        counts[k] = count_part(parts, k, size, view)


@device
def count_part(parts, k, size, view):
    """Return how many splats a part of a strand adds."""
    found = np.int64(0)
    kept = parts.kept
    begin = np.int64(parts.order[k, AT])
    for v in range(begin + 1, begin + np.int64(parts.order[k, COUNT])):
        if kept[v, WIDE] >= ZERO:
            p = kept[v - 1, X], kept[v - 1, Y], kept[v - 1, DEPTH]
            q = kept[v, X], kept[v, Y], kept[v, DEPTH]
            scale = view.focal if view.far > ZERO else view.focal * HALF * (ONE / p[2] + ONE / q[2])
            found += texels(p, q, scale, size)
    return found


@device
def texels(begin, end, scale, size):
    """Return how many texels of its longer axis a segment passes, or how many times their length it leads away from the
    light. begin, end: x and y, texels, and depth, metres; scale: texels a metre."""
    along, across = abs(end[1] - begin[1]), abs(end[0] - begin[0])
    length = max(along, across)
    if not (length >= TINY and length <= np.float32(4 * size)):
        return np.int64(0)
    away = abs(end[2] - begin[2]) * (scale * PER_TEXEL)
    parts = np.float32(np.int64(min(away / length, FINEST))) + ONE if away > length else ONE
    axis = 1 if along >= across else 0
    low, high = parts * min(begin[axis], end[axis]), parts * max(begin[axis], end[axis])
    beside = max(begin[1], end[1]) < -ONE or min(begin[1], end[1]) > np.float32(size) + ONE
    if beside or not low < high:
        return np.int64(0)
    return max(min(np.int64(high) + 1, size * np.int64(parts)) - max(np.int64(low), 0), 0)
