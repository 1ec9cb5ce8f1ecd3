"""Counts of what strands draw into a shadow map; the maps themselves do not change."""

from __future__ import annotations

import numpy as np

from ....jit import device, parallel, prange
from ...zbuffer.kernels.raster import Window
from . import splats
from .opacity_maps import PARTS, depth_of, part_range, too_short

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)


@parallel
def count_splats(first, screen, size, view, counts):
    """Write to counts (S,) int64 how many splats each strand adds to an opacity map, by the rules of
    `opacity_maps.draw_part`.

    first (S + 1,), screen (V, 3): of `opacity_maps.StrandsInMap`; size: texels along a side; view: `MapView`.
    """
    for s in prange(counts.shape[0]):
        counts[s] = 0
        for part in range(s * PARTS, (s + 1) * PARTS):
            counts[s] += count_part(first, screen, part, Window(0, size, size), view)


@device
def count_part(first, screen, part, window, view):
    """Return how many splats a part of a strand adds."""
    found = np.int64(0)
    begin, last = part_range(first, part)
    u = begin
    for v in range(begin + 1, last + 1):
        q0, q1 = screen[u, 2], screen[v, 2]
        there = q0 > ZERO and q1 > ZERO
        p = screen[u, 0], screen[u, 1], depth_of(q0, view.near, view.far) if there else ONE
        q = screen[v, 0], screen[v, 1], depth_of(q1, view.near, view.far) if there else ONE
        scale = view.focal if view.far > ZERO else view.focal * HALF * (q0 + q1)
        if v < last and there and too_short(p, q, scale):
            continue
        beside = max(p[1], q[1]) < -ONE or min(p[1], q[1]) > np.float32(window.bottom) + ONE
        if there and not beside:
            _, low, high = splats.pieces(p, q, scale, window)
            found += max(high - low, 0)
        u = v
    return found
