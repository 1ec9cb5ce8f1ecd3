"""Polylines of strands without the vertices at which they hardly bend, for opacity maps.

Each segment costs a map as much as about two of the texels that it passes, and many are no longer than that. A vertex
with an odd number in its strand is left out where the line between its neighbours passes near it, and every fourth one
where both of its neighbours are and the line between those two before and two behind it does.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined, parallel, prange
from ....simd import pointer
from ...common.kernels.numbers import ONE, ZERO
from ...geometry.kernels.curves import distance

TINY = np.float32(1e-30)
FLAT = np.float32(0.1**2)
"""Most that a vertex may be beside the line, as a share of its length, squared: segments are at most 2 % longer than
the line that stands for them."""
NEXT, TWO, THREE, FOUR = (np.uint64(number) for number in range(1, 5))
STRANDS = 128
"""Strands a task."""


@parallel
def find(first, world, lost, bent, longest, uneven, stays, counts):
    """Write which vertices stay, stays (V,) uint8: 1 or 0; and how many of each strand, counts (S,) int64.

    first (S + 1,): first vertex of each strand, and the number of vertices; world (V, 3): metres; lost (V,): share of
    its strand's width that each vertex is narrower, (0,): widths do not count; bent: how far a line may be from a
    vertex; longest: how long it may be, both squared, metres²; uneven: how much wider or narrower than the strand.
    """
    strands = first.shape[0] - 1
    for task in prange((strands + STRANDS - 1) // STRANDS):
        points = pointer(world)
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            begin, end = np.uint64(first[s]), np.uint64(first[s + 1])
            stays[begin:end] = 1
            if end - begin > TWO:
                for v in range(begin + NEXT, end - NEXT, TWO):
                    stays[v] = not passes_near(points, v, NEXT, bent, longest)
                clear_uneven(world, lost, begin, end, 1, uneven, stays)
            if end - begin > FOUR:
                for v in range(begin + TWO, end - TWO, FOUR):
                    alone = stays[v - NEXT] + stays[v + NEXT] == 0
                    stays[v] = not (alone & passes_near(points, v, TWO, bent, longest))
                clear_uneven(world, lost, begin, end, 2, uneven, stays)
            total = np.int64(0)
            for v in range(begin, end):
                total += np.int64(stays[v])
            counts[s] = total


@inlined
def passes_near(points, v, reach, bent, longest):
    """Return whether the line from the vertex `reach` before v to that `reach` behind it passes near v; points:
    `pointer` to the world, else as in `find`. Without branches."""
    a, b, c = THREE * (v - reach), THREE * (v + reach), THREE * v
    x0, y0, z0 = points[a], points[a + NEXT], points[a + TWO]
    x1, y1, z1 = points[b] - x0, points[b + NEXT] - y0, points[b + TWO] - z0
    x, y, z = points[c] - x0, points[c + NEXT] - y0, points[c + TWO] - z0
    length = x1 * x1 + y1 * y1 + z1 * z1
    along = x1 * x + y1 * y + z1 * z
    beside = (x * x + y * y + z * z) * length - along * along  # the distance's square, times that of the length
    near = (beside <= bent * length) & (beside <= FLAT * length * length)
    return near & (along >= ZERO) & (along <= length) & (length <= longest)


@device
def clear_uneven(world, lost, begin, end, reach, uneven, stays):
    """Let vertices stay where the line from that `reach` before to that `reach` behind would be wider or narrower than
    the strand, of which `lost` tells, if it has rows."""
    if lost.shape[0] == 0:
        return
    for v in range(begin + np.uint64(reach), end - np.uint64(reach)):
        a, b = v - np.uint64(reach), v + np.uint64(reach)
        if stays[v] == 0:
            before, after = distance(world, a, v), distance(world, v, b)
            t = before / max(before + after, TINY)
            if abs(lost[v] - (lost[a] + t * (lost[b] - lost[a]))) > uneven:
                stays[v] = 1


@parallel
def write(first, world, along, stays, out_first, out_world, out_along):
    """Write the vertices that stay.

    first, world, stays: as in `find`; along (V,): how far along its strand each vertex stands, None: evenly;
    out_first (S + 1,): where those of each strand begin; out_world (K, 3), out_along (K,) out."""
    strands = first.shape[0] - 1
    for task in prange((strands + STRANDS - 1) // STRANDS):
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            at, begin = np.uint64(out_first[s]), np.uint64(first[s])
            per = ONE / np.float32(max(first[s + 1] - 1 - first[s], 1))
            for v in range(begin, np.uint64(first[s + 1])):  # of a strand the last one stays
                out_world[at, 0], out_world[at, 1], out_world[at, 2] = world[v, 0], world[v, 1], world[v, 2]
                out_along[at] = np.float32(np.int64(v - begin)) * per if along is None else along[v]
                at += np.uint64(stays[v])
