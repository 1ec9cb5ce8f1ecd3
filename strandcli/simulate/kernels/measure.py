"""How far a frame is from what it should be, one number a block and kind of error."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import function, parallel, prange
from .contact import deepest

ZERO = np.float32(0)
ONE = np.float32(1)
INF = np.float32(np.inf)


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
def depth(positions, spheres, capsules, planes, boxes, out):
    """Greatest depth of a particle inside a solid, roots left out, metres.

    positions as above; solids as packed by `strandcli.solids.pack`, (m, columns) each; out (blocks,) float32.
    """
    none = spheres[:0]
    others = capsules.shape[0] + planes.shape[0] + boxes.shape[0]
    for b in prange(positions.shape[0]):
        block = positions[b]
        most = ZERO
        for m in range(spheres.shape[0]):
            most = max(most, depth_in(spheres[m], block))
        if others > 0:
            for i in range(2, block.shape[0]):
                x = block[i]
                for k in range(W):
                    most = max(most, deepest(none, capsules, planes, boxes, x[k], x[W + k], x[2 * W + k])[0])
        out[b] = most


@function
def depth_in(sphere, block):
    """Greatest depth of a block's particles inside one sphere: of each lane the nearest to the centre, then of all."""
    least = np.full(W, INF)
    for i in range(2, block.shape[0]):
        x = block[i]
        for k in range(W):
            dx = x[k] - sphere[0]
            dy = x[W + k] - sphere[1]
            dz = x[2 * W + k] - sphere[2]
            least[k] = min(least[k], dx * dx + dy * dy + dz * dz)
    return sphere[3] - math.sqrt(least.min())
