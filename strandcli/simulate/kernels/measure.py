"""How far a frame is from what it should be, one number a block and kind of error."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import parallel, prange

ZERO = np.float32(0)
ONE = np.float32(1)


@parallel
def strands(positions, lengths, out):  # type: ignore[no-untyped-def]
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
def depth(positions, spheres, capsules, planes, boxes, out):  # type: ignore[no-untyped-def]
    """Greatest depth of a particle inside a solid, roots left out, metres.

    positions as above; solids as packed by `strandcli.solids.pack`, (m, columns) each; out (blocks,) float32.
    """
    for b in prange(positions.shape[0]):
        block = positions[b]
        most = ZERO
        for i in range(2, block.shape[0]):
            x = block[i]
            for s in range(spheres.shape[0]):
                p = spheres[s]
                for k in range(W):
                    dx = x[k] - p[0]
                    dy = x[W + k] - p[1]
                    dz = x[2 * W + k] - p[2]
                    most = max(most, p[3] - math.sqrt(dx * dx + dy * dy + dz * dz))
            for s in range(capsules.shape[0]):
                p = capsules[s]
                for k in range(W):
                    dx = x[k] - p[0]
                    dy = x[W + k] - p[1]
                    dz = x[2 * W + k] - p[2]
                    t = min(max((dx * p[3] + dy * p[4] + dz * p[5]) * p[7], ZERO), ONE)
                    dx -= t * p[3]
                    dy -= t * p[4]
                    dz -= t * p[5]
                    most = max(most, p[6] - math.sqrt(dx * dx + dy * dy + dz * dz))
            for s in range(planes.shape[0]):
                p = planes[s]
                for k in range(W):
                    most = max(most, p[3] - (x[k] * p[0] + x[W + k] * p[1] + x[2 * W + k] * p[2]))
            for s in range(boxes.shape[0]):
                p = boxes[s]
                for k in range(W):
                    dx = x[k] - p[0]
                    dy = x[W + k] - p[1]
                    dz = x[2 * W + k] - p[2]
                    u = p[12] - abs(p[3] * dx + p[6] * dy + p[9] * dz)
                    v = p[13] - abs(p[4] * dx + p[7] * dy + p[10] * dz)
                    w = p[14] - abs(p[5] * dx + p[8] * dy + p[11] * dz)
                    most = max(most, min(u, min(v, w)))
        out[b] = most
