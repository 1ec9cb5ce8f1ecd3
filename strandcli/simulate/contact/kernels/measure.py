"""Errors of a frame: stretch, and depths in solids, one row for each block."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import inlined, parallel, prange
from ....simd import broadcast, half_width_pointer, lane_count, load, load3, pointer, reduce_max, sqrt
from ....simd.vectors import dot, less
from ....solids.kernels import box, capsule, custom, plane, sphere
from ....solids.kernels.built_in import device_if_built_in
from ...rod.kernels.arrays import ROW

PARTICLES, SEGMENTS = 0, 1
"""Columns of what `depths` writes."""
COLUMNS = 2


@parallel
def stretches(positions, lengths, out):
    """Write the greatest stretch | |e_i| / L − 1 | of finite segments to out (blocks,) float32.

    positions (blocks, n + 1, 3 W), lengths (blocks, W), metres.
    """
    x, size = pointer(positions), pointer(lengths)
    rows = positions.shape[1]
    for b in prange(positions.shape[0]):
        own, stretch = np.int64(b), broadcast(x, 0.0)
        for k in range(0, W, lane_count(x)):
            length = load(size, own * W + k)
            p = load3(x, (own * rows + 1) * ROW + k, W)
            for i in range(2, rows):
                q = load3(x, (own * rows + i) * ROW + k, W)
                edge, p = less(q, p), q
                stretch = max(stretch, abs(sqrt(dot(edge, edge)) / length - 1.0))
        out[b] = reduce_max(stretch)


@parallel
def depths(positions, solids, out):
    """Write the greatest depths of a particle and of any point of a segment in a solid to out (blocks, 2) float32,
    metres: columns `PARTICLES` and `SEGMENTS`.

    positions as above; solids: a `strandcli.solids.Solids`. Roots are left out, because no solver moves them, and of
    the first segment only the depth in excess of its root's counts.
    """
    for b in prange(positions.shape[0]):
        own = np.int64(b)
        most, along = deepest(solids, positions, own)
        other_most, other_along = custom.deepest(solids, positions, own)
        out[b, PARTICLES] = max(most, other_most)
        out[b, SEGMENTS] = max(along, other_along)


@device_if_built_in(lambda solids, positions, b: (np.float32(0.0), np.float32(0.0)))
def deepest(solids, positions, b):
    """Return the greatest depth of a particle of block b, and of any point of its segments, in solids of the four
    shapes."""
    spheres, capsules, planes, boxes = solids.spheres, solids.capsules, solids.planes, solids.boxes
    x = half_width_pointer(positions)  # of whole ones there are more than registers hold
    balls, pills, flats, cubes = pointer(spheres), pointer(capsules), pointer(planes), pointer(boxes)
    most = broadcast(x, 0.0)
    along = most
    for k in range(0, W, lane_count(x)):
        start = load3(x, (b * positions.shape[1] + 1) * ROW + k, W)
        for i in range(2, positions.shape[1]):
            end = load3(x, (b * positions.shape[1] + i) * ROW + k, W)
            counts = 1.0 if i == 2 else 0.0
            for m in range(0, spheres.size, spheres.shape[1]):
                most, along = deepen(sphere.depth, sphere.segment_depth, balls, m, start, end, counts, most, along)
            for m in range(0, capsules.size, capsules.shape[1]):
                most, along = deepen(capsule.depth, capsule.segment_depth, pills, m, start, end, counts, most, along)
            for m in range(0, planes.size, planes.shape[1]):
                most, along = deepen(plane.depth, plane.segment_depth, flats, m, start, end, counts, most, along)
            for m in range(0, boxes.size, boxes.shape[1]):
                most, along = deepen(box.least_depth, box.segment_depth, cubes, m, start, end, counts, most, along)
            start = end
    return reduce_max(most), reduce_max(along)


@inlined
def deepen(depth, segment_depth, p, m, start, end, counts, most, along):
    """Return the greatest depths so far and in solid m of p: of the ends of segments, and of any of their points less
    that of their starts, if that ``counts``, 1 or 0."""
    edge = less(end, start)
    over = counts * max(depth(p, m, start[0], start[1], start[2]), 0.0)
    most = max(most, depth(p, m, end[0], end[1], end[2]))
    return most, max(along, segment_depth(p, m, start, edge) - over)
