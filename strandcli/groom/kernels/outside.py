"""A point out of the solids that it is in: one after the other, each along its own normal."""

from __future__ import annotations

import math

import numpy as np

from ...jit import device

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-20)


@device
def outside(x, y, z, clear, spheres, capsules, planes, boxes):
    """The point, `clear` metres off the surface of every solid that it was in or nearer to. Solids as packed by
    `strandcli.solids.pack`."""
    for s in range(spheres.shape[0]):
        x, y, z = off(x, y, z, spheres[s, 0], spheres[s, 1], spheres[s, 2], spheres[s, 3] + clear)
    for s in range(capsules.shape[0]):
        t = (x - capsules[s, 0]) * capsules[s, 3] + (y - capsules[s, 1]) * capsules[s, 4]
        t = min(max((t + (z - capsules[s, 2]) * capsules[s, 5]) * capsules[s, 7], ZERO), ONE)
        x, y, z = off(
            x, y, z, capsules[s, 0] + t * capsules[s, 3], capsules[s, 1] + t * capsules[s, 4],
            capsules[s, 2] + t * capsules[s, 5], capsules[s, 6] + clear,
        )  # fmt: skip
    for s in range(planes.shape[0]):
        deep = max(planes[s, 3] + clear - (x * planes[s, 0] + y * planes[s, 1] + z * planes[s, 2]), ZERO)
        x += deep * planes[s, 0]
        y += deep * planes[s, 1]
        z += deep * planes[s, 2]
    for s in range(boxes.shape[0]):
        least = np.float32(np.inf)
        face = 0
        side = ONE
        for k in range(3):
            u = boxes[s, 3 + k] * (x - boxes[s, 0]) + boxes[s, 6 + k] * (y - boxes[s, 1])
            u += boxes[s, 9 + k] * (z - boxes[s, 2])
            under = boxes[s, 12 + k] + clear - abs(u)
            if under < least:
                least = under
                face = k
                side = ONE if u >= ZERO else -ONE
        deep = side * max(least, ZERO)
        x += deep * boxes[s, 3 + face]
        y += deep * boxes[s, 6 + face]
        z += deep * boxes[s, 9 + face]
    return x, y, z


@device
def off(x, y, z, ox, oy, oz, r):
    """A point at the distance r from (ox, oy, oz) at the least; one at the very centre leaves upward."""
    dx = x - ox
    dy = y - oy
    dz = z - oz
    square = dx * dx + dy * dy + dz * dz
    if square >= r * r:
        return x, y, z
    if square < TINY:
        return ox, oy + r, oz
    f = r / math.sqrt(square)
    return ox + dx * f, oy + dy * f, oz + dz * f
