"""Search for nearest neighbours."""

from __future__ import annotations

import numpy as np

from ...jit import parallel, prange

ZERO = np.float32(0.0)
X = 0


@parallel
def nearest(points, others, order, out, distances):
    """Write the nearest K of others to each point to out (N, K) int32, nearest first, and their squared distances to
    distances (N, K) float32.

    points (N, 4), others (G, 4) float32, the latter in ascending order of coordinate `X`, which bounds the search;
    order (G,) int32: the numbers to write for them; K <= G.
    """
    count = others.shape[0]
    most = out.shape[1]
    for i in prange(points.shape[0]):
        found = distances[i]
        names = out[i]
        found[:] = np.float32(np.inf)
        x = points[i, X]
        low = np.int64(0)
        high = np.int64(count)
        while low < high:
            middle = (low + high) // 2
            if others[middle, X] < x:
                low = middle + 1
            else:
                high = middle
        right = low
        left = low - 1
        while True:
            before = x - others[left, X] if left >= 0 else np.float32(np.inf)
            after = others[right, X] - x if right < count else np.float32(np.inf)
            way = min(before, after)
            if not way * way < found[most - 1]:
                break
            if before < after:
                at = left
                left -= 1
            else:
                at = right
                right += 1
            square = ZERO
            for c in range(4):
                d = points[i, c] - others[at, c]
                square += d * d
            place = most - 1
            if square < found[place]:
                while place > 0 and square < found[place - 1]:
                    found[place] = found[place - 1]
                    names[place] = names[place - 1]
                    place -= 1
                found[place] = square
                names[place] = order[at]
