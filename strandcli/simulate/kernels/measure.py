"""Errors of a frame: stretch, coordinates that are not finite, depths in solids, one row for each block; momentum."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import function, parallel, prange
from ...simd import any_lane, broadcast, half_width_pointer, lane_count, load, load3, pointer, reduce_max, sqrt, store
from ...solids.kernels import box, capsule, other, plane, sphere
from ...solids.kernels.built_in import device_if_built_in
from ..rod.kernels.arrays import AXES, PACK, ROW

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
        own = np.int64(b)
        stretch, finite = stretches(positions, lengths, own)
        bad = 0
        if not finite:
            for i in range(1, positions.shape[1]):
                for j in range(ROW):
                    if not math.isfinite(positions[own, i, j]):
                        bad += 1
        out[b, STRETCH] = stretch
        out[b, NOT_FINITE] = bad


@function
def stretches(positions, lengths, b):
    """Return the greatest stretch of block b, and whether all of its coordinates are finite."""
    x, size = pointer(positions), pointer(lengths)
    rows = positions.shape[1]
    stretch = broadcast(x, 0.0)
    none = stretch
    for k in range(0, W, lane_count(x)):
        length = load(size, b * W + k)
        p = load3(x, (b * rows + 1) * ROW + k, W)
        none = none + (p[0] * 0.0 + p[1] * 0.0 + p[2] * 0.0)  # NaN in lanes where one is not finite
        for i in range(2, rows):
            q = load3(x, (b * rows + i) * ROW + k, W)
            none = none + (q[0] * 0.0 + q[1] * 0.0 + q[2] * 0.0)
            dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
            stretch = max(stretch, abs(sqrt(dx * dx + dy * dy + dz * dz) / length - 1.0))
            p = q
    return reduce_max(stretch), not any_lane(none != 0.0)


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
        other_most, other_along = other.deepest(solids, positions, own)
        out[b, PARTICLES] = max(most, other_most)
        out[b, SEGMENTS] = max(along, other_along)


@device_if_built_in(lambda solids, positions, b: (np.float32(0.0), np.float32(0.0)))
def deepest(solids, positions, b):
    """Return the greatest depth of a particle of block b, and of any point of its segments, in solids of the four
    shapes."""
    spheres, capsules, planes, boxes = solids.spheres, solids.capsules, solids.planes, solids.boxes
    x = half_width_pointer(positions)  # of whole ones there are more than registers hold
    balls, pills, flats, cubes = pointer(spheres), pointer(capsules), pointer(planes), pointer(boxes)
    particles = positions.shape[1] - 1
    most = broadcast(x, 0.0)
    along = most
    for k in range(0, W, lane_count(x)):
        roots = (b * positions.shape[1] + 1) * ROW + k
        for m in range(0, spheres.size, spheres.shape[1]):
            ends, inner = sphere.deepest(balls, m, x, roots, particles)
            most, along = max(most, ends), max(along, inner)
        for m in range(0, capsules.size, capsules.shape[1]):
            ends, inner = capsule.deepest(pills, m, x, roots, particles)
            most, along = max(most, ends), max(along, inner)
        for m in range(0, planes.size, planes.shape[1]):
            ends, inner = plane.deepest(flats, m, x, roots, particles)
            most, along = max(most, ends), max(along, inner)
        for m in range(0, boxes.size, boxes.shape[1]):
            ends, inner = box.deepest(cubes, m, x, roots, particles)
            most, along = max(most, ends), max(along, inner)
    return reduce_max(most), reduce_max(along)


@parallel
def carried(velocity, mass, out):
    """Set the sums over particles of relative mass times speed, m/s, of each strand: out (P, S). ``velocity``: (P, N,
    3 S) m/s; ``mass`` (N,)."""
    read, found = pointer(velocity), pointer(out)
    n = velocity.shape[1]
    for pack in prange(len(velocity)):
        for k in range(0, PACK, lane_count(read)):
            sums = broadcast(read, 0.0)
            for j in range(n):
                u, v, w = load3(read, (pack * n + j) * AXES + k, PACK)
                sums += mass[j] * sqrt(u * u + v * v + w * w)
            store(found, pack * PACK + k, sums)
