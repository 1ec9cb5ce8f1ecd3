"""Level of detail strand by strand (see `strandcli.draw.geometry.detail`)."""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, function, parallel, prange

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)


@parallel
def choose(positions, ids, total, eye, near, least, band, fade, wider):
    """What is drawn of each strand, and by how much wider.

    positions (blocks, n + 1, 3 W) float32; ids (strands,) int32: places in the order of all `total`, or (0,) where they
    are 0, 1, …; eye (3,) float64 metres, or (0,) where `near` is the share itself; near: distance up to which all are
    kept; least: smallest share; band: see `strandcli.draw.geometry.detail`; fade, wider (strands,) float32.
    """
    for s in prange(fade.shape[0]):
        k = near
        if eye.shape[0] > 0:
            square = 0.0
            for c in range(3):
                d = positions[s // W, 1, c * W + s % W] - eye[c]
                square += d * d
            k = near / max(math.sqrt(square), 1e-30)
        k = min(max(k, least), 1.0)
        wide = max(band * k, 1.0 / total)
        place = ((s if ids.shape[0] == 0 else np.int64(ids[s])) + 0.5) / total
        fade[s] = min(max((k + wide - place) / wide, 0.0), 1.0)
        beyond = max(k + wide - 1.0, 0.0)
        wider[s] = 1.0 / (k + 0.5 * wide - 0.5 * beyond * beyond / wide)


@parallel
def shorten(first, world, fade):
    """Of strands that fade the part next to the root is left, by length: all vertices beyond come to one point.

    first (S + 1,) int64; world (V, 3) metres; fade (S,).
    """
    for s in prange(fade.shape[0]):
        if fade[s] < ONE:
            cut(world, first[s], first[s + 1], fade[s])


@device
def cut(world, begin, end, part):
    """Leave a part of the length of one polyline."""
    left = ZERO
    for v in range(begin + 1, end):
        left += apart(world, v - 1, v)
    left *= part
    for v in range(begin + 1, end):
        length = apart(world, v - 1, v)
        t = min(left / max(length, TINY), ONE)
        left -= t * length
        if t < ONE:
            for c in range(3):
                world[v, c] = world[v - 1, c] + t * (world[v, c] - world[v - 1, c])
            for w in range(v + 1, end):
                for c in range(3):
                    world[w, c] = world[v, c]
            return


@function
def apart(world, v, w):
    """Distance between two vertices."""
    x = world[w, 0] - world[v, 0]
    y = world[w, 1] - world[v, 1]
    z = world[w, 2] - world[v, 2]
    return math.sqrt(x * x + y * y + z * z)
