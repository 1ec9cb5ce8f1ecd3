"""The most alike of many strands to each of many others."""

from __future__ import annotations

import numpy as np

from ...jit import device, parallel, prange
from ...jit.search import first_not_below


@parallel
def most_alike(points, others, order, out, squares):
    """The nearest of others to each point, nearest first.

    points (N, D), others (G, D) float32, the latter in the ascending order of their first coordinate, which bounds the
    search; order (G,) int32: what to call each; out (N, K) int32, K <= G; squares (N, K) float32: squared distances.
    """
    for i in prange(points.shape[0]):
        search(points[i], others, order, out[i], squares[i])


@device
def search(point, others, order, names, found):
    """`most_alike` of one point."""
    count = others.shape[0]
    last = names.shape[0] - 1
    found[:] = np.float32(np.inf)
    right = first_not_below(others[:, 0], point[0])
    left = right - 1
    while True:
        before = point[0] - others[left, 0] if left >= 0 else np.float32(np.inf)
        after = others[right, 0] - point[0] if right < count else np.float32(np.inf)
        way = min(before, after)
        if not way * way < found[last]:
            return
        if before < after:
            at = left
            left -= 1
        else:
            at = right
            right += 1
        insert(others, at, point, order[at], names, found)


@device
def insert(others, at, point, name, names, found):
    """Put one of the others in its place among those found, where it is nearer than the last of them."""
    square = np.float32(0.0)
    last = names.shape[0] - 1
    for c in range(point.shape[0]):
        d = point[c] - others[at, c]
        square += d * d
        if not square < found[last]:
            return
    k = last
    while k > 0 and square < found[k - 1]:
        found[k] = found[k - 1]
        names[k] = names[k - 1]
        k -= 1
    found[k] = square
    names[k] = name
