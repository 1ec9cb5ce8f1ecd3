"""Counts of what strands draw into a shadow map; the maps themselves do not change."""

from __future__ import annotations

import numpy as np

from ....jit import parallel, prange
from .splats import SHORT

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)


@parallel
def count_splats(first, screen, size, view, counts):
    """Write to counts (S,) int64 how many splats each strand adds to an opacity map, by the rule of `splats.collect`.

    first (S + 1,), screen (V, 3): of `opacity_maps.StrandsInMap`; size: texels along a side; view: `MapView`.
    """
    far, near, focal = view.far, view.near, view.focal
    low, high = -ONE, np.float32(size) + ONE
    for s in prange(counts.shape[0]):
        found = np.int64(0)
        for v in range(first[s] + 1, first[s + 1]):
            y0, y1 = screen[v - 1, 1], screen[v, 1]
            q0, q1 = screen[v - 1, 2], screen[v, 2]
            if max(y0, y1) < low or min(y0, y1) > high or q0 <= ZERO or q1 <= ZERO:
                continue
            if far > ZERO:
                rise, scale = near + (ONE - q1) * far - (near + (ONE - q0) * far), focal
            else:
                rise, scale = ONE / q1 - ONE / q0, focal * HALF * (q0 + q1)
            length = max(abs(screen[v, 0] - screen[v - 1, 0]), abs(y1 - y0), abs(rise) * scale)
            if length <= np.float32(4 * size):
                found += np.int64(length) + 1 if length > SHORT else np.int64(1)
        counts[s] = found
