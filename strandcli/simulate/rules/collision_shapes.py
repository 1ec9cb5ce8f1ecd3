"""Putting a particle onto the surface of a solid that it is inside of: one function a kind of solid.

`p` holds one solid a row, packed by `strandcli.solids.pack`. Lanes that are outside pass through unchanged:
nothing in a loop branches.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...constants import W

ZERO = np.float32(0)
HALF = np.float32(0.5)
ONE = np.float32(1)


def sphere(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """p (m, 5): centre, radius, tiny."""
    for s in range(p.shape[0]):
        ox = p[s, 0]
        oy = p[s, 1]
        oz = p[s, 2]
        r = p[s, 3]
        tiny = p[s, 4]
        reach = r * r
        inside = 0
        for k in range(W):
            dx = x[k] - ox
            dy = x[W + k] - oy
            dz = x[2 * W + k] - oz
            inside += 1 if dx * dx + dy * dy + dz * dz < reach else 0
        if inside == 0:  # no lane needs the roots and divisions below
            continue
        for k in range(W):
            dx = x[k] - ox
            dy = x[W + k] - oy
            dz = x[2 * W + k] - oz
            square = dx * dx + dy * dy + dz * dz
            size = math.sqrt(max(square, tiny))
            # at the centre, where nothing points outward, up does
            dy = dy if square > tiny else size
            f = max(r / size - ONE, ZERO)
            x[k] += dx * f
            x[W + k] += dy * f
            x[2 * W + k] += dz * f


def capsule(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """p (m, 9): first end, vector to the other end, radius, 1 / its squared length, tiny. A particle on the axis leaves
    across it."""
    for s in range(p.shape[0]):
        ax = p[s, 0]
        ay = p[s, 1]
        az = p[s, 2]
        bx = p[s, 3]
        by = p[s, 4]
        bz = p[s, 5]
        r = p[s, 6]
        per = p[s, 7]
        tiny = p[s, 8]
        # a ball about the capsule: where no lane is in it, there is nothing to do
        mx = ax + HALF * bx
        my = ay + HALF * by
        mz = az + HALF * bz
        reach = HALF * math.sqrt(bx * bx + by * by + bz * bz) + r
        reach *= reach
        near = 0
        for k in range(W):
            dx = x[k] - mx
            dy = x[W + k] - my
            dz = x[2 * W + k] - mz
            near += 1 if dx * dx + dy * dy + dz * dz <= reach else 0
        if near == 0:
            continue
        # a direction across the axis, for particles on it
        flat = bx * bx + bz * bz
        size = math.sqrt(max(flat, tiny))
        ux = r * bz / size if flat > tiny else r
        uz = -r * bx / size if flat > tiny else ZERO
        for k in range(W):
            dx = x[k] - ax
            dy = x[W + k] - ay
            dz = x[2 * W + k] - az
            t = min(max((dx * bx + dy * by + dz * bz) * per, ZERO), ONE)
            dx -= t * bx
            dy -= t * by
            dz -= t * bz
            square = dx * dx + dy * dy + dz * dz
            f = max(r / math.sqrt(max(square, tiny)) - ONE, ZERO) if square > tiny else ZERO
            x[k] += dx * f if square > tiny else ux
            x[W + k] += dy * f
            x[2 * W + k] += dz * f if square > tiny else uz


def plane(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """p (m, 4): unit normal, distance of the plane from the origin; everything below it is solid."""
    for s in range(p.shape[0]):
        nx = p[s, 0]
        ny = p[s, 1]
        nz = p[s, 2]
        c = p[s, 3]
        for k in range(W):
            out = max(c - (x[k] * nx + x[W + k] * ny + x[2 * W + k] * nz), ZERO)
            x[k] += nx * out
            x[W + k] += ny * out
            x[2 * W + k] += nz * out


def box(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """p (m, 16): centre, rotation by rows (world = R local), half extents, tiny. Out through the nearest face."""
    for s in range(p.shape[0]):
        for k in range(W):
            dx = x[k] - p[s, 0]
            dy = x[W + k] - p[s, 1]
            dz = x[2 * W + k] - p[s, 2]
            u = p[s, 3] * dx + p[s, 6] * dy + p[s, 9] * dz
            v = p[s, 4] * dx + p[s, 7] * dy + p[s, 10] * dz
            w = p[s, 5] * dx + p[s, 8] * dy + p[s, 11] * dz
            du = p[s, 12] - abs(u)
            dv = p[s, 13] - abs(v)
            dw = p[s, 14] - abs(w)
            least = min(du, min(dv, dw))
            inside = max(least, ZERO)
            by_u = inside if du <= least else ZERO
            by_v = inside if (dv <= least) and (du > least) else ZERO
            by_w = inside - by_u - by_v
            by_u = by_u if u >= ZERO else -by_u
            by_v = by_v if v >= ZERO else -by_v
            by_w = by_w if w >= ZERO else -by_w
            x[k] += p[s, 3] * by_u + p[s, 4] * by_v + p[s, 5] * by_w
            x[W + k] += p[s, 6] * by_u + p[s, 7] * by_v + p[s, 8] * by_w
            x[2 * W + k] += p[s, 9] * by_u + p[s, 10] * by_v + p[s, 11] * by_w
