"""Polylines of strands without the vertices at which they hardly bend, for opacity maps.

Each segment costs a map as much as about two of the texels that it passes, and many are no longer than that. A vertex
with an odd number in its strand is left out where the line between its neighbours passes near it, and every fourth one
where both of its neighbours are and the line between those two before and two behind it does.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, parallel, prange
from ...common.kernels.numbers import ONE, ZERO
from ...geometry.kernels.curves import distance

TINY = np.float32(1e-30)
FLAT = np.float32(0.1**2)
"""Most that a vertex may be beside the line, as a share of its length, squared: segments are at most 2 % longer than
the line that stands for them."""
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
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            begin, end = first[s], first[s + 1]
            left_out = np.int64(0)
            stays[begin:end] = 1
            for reach in range(1, 3):  # odd ones, then those between two that are left out
                for v in range(begin + reach, end - reach, 2 * reach):
                    alone = reach == 1 or stays[v - 1] + stays[v + 1] == 0
                    if alone and passes_near(world, lost, v, reach, bent, longest, uneven):
                        stays[v] = 0
                        left_out += 1
            counts[s] = end - begin - left_out


@device
def passes_near(world, lost, v, reach, bent, longest, uneven):
    """Return whether the line from the vertex `reach` before v to that `reach` behind it passes near v, and about as
    wide as the strand is there; arguments as in `find`."""
    a, b = v - reach, v + reach
    x0, y0, z0 = world[a, 0], world[a, 1], world[a, 2]
    x1, y1, z1 = world[b, 0] - x0, world[b, 1] - y0, world[b, 2] - z0
    x, y, z = world[v, 0] - x0, world[v, 1] - y0, world[v, 2] - z0
    length = x1 * x1 + y1 * y1 + z1 * z1
    along = x1 * x + y1 * y + z1 * z
    beside = (x * x + y * y + z * z) * length - along * along  # the distance's square, times that of the length
    near = (beside <= bent * length) & (beside <= FLAT * length * length)
    near = near & (along >= ZERO) & (along <= length) & (length <= longest)
    if near and lost.shape[0] > 0:
        before, after = distance(world, a, v), distance(world, v, b)
        t = before / max(before + after, TINY)
        return abs(lost[v] - (lost[a] + t * (lost[b] - lost[a]))) <= uneven
    return near


@parallel
def write(first, world, along, stays, out_first, out_world, out_along):
    """Write the vertices that stay.

    first, world, stays: as in `find`; along (V,): how far along its strand each vertex stands, None: evenly;
    out_first (S + 1,): where those of each strand begin; out_world (K, 3), out_along (K,) out."""
    strands = first.shape[0] - 1
    for task in prange((strands + STRANDS - 1) // STRANDS):
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            at, begin = out_first[s], first[s]
            per = ONE / np.float32(max(first[s + 1] - 1 - begin, 1))
            for v in range(begin, first[s + 1]):
                if stays[v] > 0:
                    out_world[at, 0], out_world[at, 1], out_world[at, 2] = world[v, 0], world[v, 1], world[v, 2]
                    out_along[at] = np.float32(v - begin) * per if along is None else along[v]
                    at += 1
