"""Errors of a frame: stretch, coordinates that are not finite, depths in solids; one row for each block."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import function, inlined, parallel, prange
from ...simd import any_lane, broadcast, lane_count, load3, pointer, reduce_max, sqrt
from ...solids.kernels import box, capsule, other, plane, sphere

ZERO = np.float32(0)
ONE = np.float32(1)
ROW = 3 * W
"""Numbers of a row of positions."""
STRETCH, NOT_FINITE = 0, 1
"""Columns of what `strands` writes."""
PARTICLES, SEGMENTS = 0, 1
"""Columns of what `depths` writes."""
COLUMNS = 2


@parallel
def strands(positions, lengths, out):
    """Write the greatest stretch | |e_i| / L − 1 | and the number of coordinates that are not finite to out (blocks, 2)
    float32: columns `STRETCH` and `NOT_FINITE`.

    positions (blocks, n + 1, 3 W), lengths (blocks, W), metres.
    """
    for b in prange(positions.shape[0]):
        block = positions[b]
        stretch = ZERO
        bad = 0
        for i in range(1, block.shape[0]):
            x = block[i]
            for j in range(3 * W):
                if not math.isfinite(x[j]):
                    bad += 1
            if i == 1:
                continue
            q = block[i - 1]
            for k in range(W):
                dx = x[k] - q[k]
                dy = x[W + k] - q[W + k]
                dz = x[2 * W + k] - q[2 * W + k]
                stretch = max(stretch, abs(math.sqrt(dx * dx + dy * dy + dz * dz) / lengths[b, k] - ONE))
        out[b, STRETCH] = stretch
        out[b, NOT_FINITE] = bad


@parallel
def depths(positions, solids, out):
    """Write the greatest depths of a particle and of any point of a segment in a solid to out (blocks, 2) float32,
    metres: columns `PARTICLES` and `SEGMENTS`.

    positions as above; solids: a `strandcli.solids.Solids`. Roots are left out, because no solver moves them, and of
    the first segment only the depth in excess of its root's counts.
    """
    for b in prange(positions.shape[0]):
        own = np.int64(b)
        most, along = deepest(positions, own, solids)
        other_most, other_along = other.deepest(solids, positions, own)
        out[b, PARTICLES] = max(most, other_most)
        out[b, SEGMENTS] = max(along, other_along)


@function
def deepest(positions, b, solids):
    """Return the greatest depth of a particle of block b, and of any point of its segments, in solids of the four
    shapes."""
    spheres, capsules, planes, boxes = solids.spheres, solids.capsules, solids.planes, solids.boxes
    x = pointer(positions)
    balls, pills, flats, cubes = pointer(spheres), pointer(capsules), pointer(planes), pointer(boxes)
    most = broadcast(x, 0.0)
    along = most
    for i in range(2, positions.shape[1]):
        first = i == 2
        for k in range(0, W, lane_count(x)):
            p = load3(x, (b * positions.shape[1] + i - 1) * ROW + k, W)
            q = load3(x, (b * positions.shape[1] + i) * ROW + k, W)
            e = q[0] - p[0], q[1] - p[1], q[2] - p[2]
            size = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
            for m in range(0, spheres.size, spheres.shape[1]):
                depth = sphere.depth(balls, m, q[0], q[1], q[2])
                most = max(most, depth)
                if any_lane(depth + size > 0.0):
                    under = sphere.depth(balls, m, p[0], p[1], p[2])
                    along = max(along, beyond_root(sphere.segment_depth(balls, m, p, e), under, first))
            for m in range(0, capsules.size, capsules.shape[1]):
                depth = capsule.depth(pills, m, q[0], q[1], q[2])
                most = max(most, depth)
                if any_lane(depth + size > 0.0):
                    under = capsule.depth(pills, m, p[0], p[1], p[2])
                    along = max(along, beyond_root(capsule.segment_depth(pills, m, p, e), under, first))
            for m in range(0, planes.size, planes.shape[1]):
                depth = plane.depth(flats, m, q[0], q[1], q[2])
                most = max(most, depth)
                under = plane.depth(flats, m, p[0], p[1], p[2])
                along = max(along, beyond_root(max(depth, under), under, first))
            for m in range(0, boxes.size, boxes.shape[1]):
                depth = box.depth(cubes, m, q[0], q[1], q[2])[0]
                most = max(most, depth)
                if any_lane(depth + size > 0.0):
                    under = box.depth(cubes, m, p[0], p[1], p[2])[0]
                    along = max(along, beyond_root(box.segment_depth(cubes, m, p, e), under, first))
    return reduce_max(most), reduce_max(along)


@inlined
def beyond_root(depth, under, first):
    """Return the depth of a segment; of the ``first``, what exceeds the depth ``under`` of its root."""
    return depth - max(under, 0.0) if first else depth
