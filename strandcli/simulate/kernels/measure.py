"""How far a frame is from what it should be, one number a block and kind of error."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import function, parallel, prange
from ...simd import broadcast, lane_count, load3, pointer, reduce_max
from ...solids.kernels import box, capsule, plane, sphere

ZERO = np.float32(0)
ONE = np.float32(1)


@parallel
def strands(positions, lengths, out):
    """Stretch and non-finite coordinates.

    positions (blocks, n + 1, 3 W), lengths (blocks, W); out (blocks, 2) float32: greatest | |e_i| / L − 1 |, and the
    number of coordinates that are not finite.
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
        out[b, 0] = stretch
        out[b, 1] = bad


@parallel
def depth(positions, solids, out):
    """Greatest depth of a particle inside a solid, roots left out, metres.

    positions as above; solids: `strandcli.solids.Solids`; out (blocks,) float32.
    """
    for b in prange(positions.shape[0]):
        out[b] = deepest(positions, np.int64(b), solids)


@function
def deepest(positions, b, solids):
    """That of one block."""
    rows = positions.shape[1]
    where, balls, pills = pointer(positions), pointer(solids.spheres), pointer(solids.capsules)
    flats, cubes = pointer(solids.planes), pointer(solids.boxes)
    most = broadcast(where, 0.0)
    for i in range(2, rows):
        for k in range(0, W, lane_count(where)):
            x, y, z = load3(where, (b * rows + i) * 3 * W + k, W)
            for m in range(0, solids.spheres.size, solids.spheres.shape[1]):
                dx, dy, dz = x - balls[m], y - balls[m + 1], z - balls[m + 2]
                most = max(most, sphere.under(dx, dy, dz, balls[m + sphere.RADIUS]))
            for m in range(0, solids.capsules.size, solids.capsules.shape[1]):
                most = max(most, capsule.depth(pills, m, x, y, z))
            for m in range(0, solids.planes.size, solids.planes.shape[1]):
                most = max(most, plane.depth(flats, m, x, y, z))
            for m in range(0, solids.boxes.size, solids.boxes.shape[1]):
                most = max(most, box.depth(cubes, m, x, y, z)[0])
    return reduce_max(most)
