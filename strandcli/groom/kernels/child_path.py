"""The paths of children along their guides and clumps: child by child, a vector of the numbers of a row at a time."""

from __future__ import annotations

import numpy as np

from ...jit import device, inlined
from ...simd import broadcast, lane_count, load, load_triple, pointer, store

ONE_PLACE = np.uint64(1)
TWO_PLACES = np.uint64(2)


@device
def lay_path(guides, following, i, rows, o):
    """Write the path of child i along its guides to rows from place o on, as a row of `Guides.offsets`, in metres from
    the origin."""
    step = lane_count(rows)
    a, b, c = load_triple(pointer(following.roots), np.int64(i) * 3)
    lay_third(guides, following, i, rows, o, 0, a)
    lay_third(guides, following, i, rows, o, step, b)
    lay_third(guides, following, i, rows, o, 2 * step, c)


@inlined
def lay_third(guides, following, i, rows, o, begin, root):
    """`lay_path` of every third vector from place ``begin`` of the row on; root: the child's root in these."""
    every = pointer(guides.offsets)
    size, step = guides.offsets.shape[1], 3 * lane_count(rows)
    first = np.int64(following.parents[i, np.uint64(0)]) * size
    second = np.int64(following.parents[i, ONE_PLACE]) * size
    third = np.int64(following.parents[i, TWO_PLACES]) * size
    u = broadcast(rows, following.weights[i, np.uint64(0)])
    v = broadcast(rows, following.weights[i, ONE_PLACE])
    w = broadcast(rows, following.weights[i, TWO_PLACES])
    for k in range(begin, size, step):
        x = root + u * load(every, first + k) + v * load(every, second + k) + w * load(every, third + k)
        store(rows, o + k, x)


@device
def pull_path(clumps, i, rows, o):
    """Pull the path of child i, in rows from place o on, to the paths at the centres of its clumps, from the narrowest
    to the widest."""
    centres, ramps, size = pointer(clumps.paths), pointer(clumps.ramps), clumps.paths.shape[1]
    for level in range(clumps.centres.shape[0] - 1, -1, -1):
        pull = broadcast(rows, clumps.pulls[np.uint64(level), i])
        centre, ramp = np.int64(clumps.centres[np.uint64(level), i]) * size, level * size
        for k in range(0, size, lane_count(rows)):
            x = load(rows, o + k)
            store(rows, o + k, x + pull * load(ramps, ramp + k) * (load(centres, centre + k) - x))
