"""Strands that are combed to a tie: kept out of what they lie over, and carried along with the emitter."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import device, parallel, prange

STEPS = 128
"""At the most, to leave a solid: a way out at right angles takes one."""
ENOUGH = 1e-7
"""Metres that a point may be inside."""


@parallel
def clear(points, normals, solids, k, out):
    """How far up points (N, 3) have to be moved along unit normals (N, 3) to be outside, metres, into out (N,).

    solids (m, 9): first end, vector to the other end, radius, 1 / its squared length, and 1 where it blends; k: the
    way of blending, metres. What blends is one surface at the distance −k ln Σ e^(−dᵢ / k), which is never more than
    the way along any line to where it is 0, so that steps of it cannot pass over that.
    """
    for i in prange(points.shape[0]):
        up = 0.0
        for _ in range(STEPS):
            away = distance(
                points[i, 0] + up * normals[i, 0], points[i, 1] + up * normals[i, 1], points[i, 2] + up * normals[i, 2],
                solids, k,
            )  # fmt: skip
            if away >= -ENOUGH:
                break
            up -= away
        out[i] = up


@device
def distance(x, y, z, solids, k):
    """From the surface of all solids together to a point, metres, negative inside."""
    least = np.inf
    plain = np.inf
    total = 0.0
    for m in range(solids.shape[0]):
        ox = x - solids[m, 0]
        oy = y - solids[m, 1]
        oz = z - solids[m, 2]
        t = min(max((ox * solids[m, 3] + oy * solids[m, 4] + oz * solids[m, 5]) * solids[m, 7], 0.0), 1.0)
        ox -= t * solids[m, 3]
        oy -= t * solids[m, 4]
        oz -= t * solids[m, 5]
        away = math.sqrt(ox * ox + oy * oy + oz * oz) - solids[m, 6]
        if solids[m, 8] == 0.0:
            plain = min(plain, away)
        elif away < least:
            total = total * math.exp((away - least) / k) + 1.0 if total > 0.0 else 1.0
            least = away
        else:
            total += math.exp((least - away) / k)
    if total > 0.0:
        plain = min(plain, least - k * math.log(total))
    return plain


@parallel
def join(combed, hanging, rotation, shift, out):
    """Strands from root to tip: what is combed, moved with the emitter, then what hangs from the tie.

    combed (blocks, 1 + P, 3 W) float32 in the emitter's frame: the row before the root, then the points up to the tie;
    hanging (blocks, n + 1, 3 W) metres, whose row 1 is at the tie and whose row 0 is left out; rotation (9,) by rows
    and shift (3,) float32: the emitter's pose; out (blocks, 1 + P + n, 3 W).
    """
    rows = combed.shape[1]
    for block in prange(out.shape[0]):
        for row in range(rows):
            for c in range(3):
                a = rotation[3 * c]
                b = rotation[3 * c + 1]
                d = rotation[3 * c + 2]
                e = shift[c]
                for k in range(W):
                    x = combed[block, row, k]
                    y = combed[block, row, W + k]
                    z = combed[block, row, 2 * W + k]
                    out[block, row, c * W + k] = (a * x + b * y) + d * z + e
        for row in range(1, hanging.shape[1]):
            for k in range(3 * W):
                out[block, rows + row - 1, k] = hanging[block, row, k]
