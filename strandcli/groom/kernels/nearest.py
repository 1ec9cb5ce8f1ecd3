"""The nearest of many points to each of many others."""

from __future__ import annotations

import numpy as np

from ...jit import parallel, prange

ZERO = np.float32(0.0)


@parallel
def nearest(points, others, order, out, distances):
    """The nearest of others to each point, nearest first.

    points (N, 4), others (G, 4) float32, the latter in the ascending order of their first coordinate, which bounds the
    search; order (G,) int32: what to call each; out (N, K) int32, K <= G; distances (N, K) float32: squared.
    """
    count = others.shape[0]
    most = out.shape[1]
    for i in prange(points.shape[0]):
        found = distances[i]
        names = out[i]
        found[:] = np.float32(np.inf)
        x = points[i, 0]
        low = np.int64(0)
        high = np.int64(count)
        while low < high:
            middle = (low + high) // 2
            if others[middle, 0] < x:
                low = middle + 1
            else:
                high = middle
        right = low
        left = low - 1
        while True:
            before = x - others[left, 0] if left >= 0 else np.float32(np.inf)
            after = others[right, 0] - x if right < count else np.float32(np.inf)
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
