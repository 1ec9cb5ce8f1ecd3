"""Level of detail of each strand (see `strandcli.draw.geometry.detail`)."""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, function, parallel, prange
from ...common.kernels.numbers import ONE, ZERO

TINY = np.float32(1e-30)


@parallel
def fade_by_distance(positions, ranks, total, eye, near, least, band, fade, scale):
    """Write how much of each strand is drawn, 0 to 1, and the factor of its width.

    positions (blocks, n + 1, 3 W) float32, metres; ranks (strands,) int32: in the order of all `total` strands, or
    (0,): 0, 1, …; eye (3,) float64, metres, or (0,): `near` is the fraction k of all strands; near: distance up to
    which all strands are drawn, metres; least: smallest fraction; band: width of the fade as a fraction of k; fade,
    scale (strands,) float32, written.
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
        rank = ((s if ranks.shape[0] == 0 else np.int64(ranks[s])) + 0.5) / total
        fade[s] = min(max((k + wide - rank) / wide, 0.0), 1.0)
        beyond = max(k + wide - 1.0, 0.0)
        scale[s] = 1.0 / (k + 0.5 * wide - 0.5 * beyond * beyond / wide)


@parallel
def shorten(first, world, fade):
    """Shorten each strand that fades to the fraction `fade` of its length from the root; vertices beyond that are moved
    to the new tip.

    first (S + 1,) int64; world (V, 3) metres, changed; fade (S,).
    """
    for s in prange(fade.shape[0]):
        if fade[s] < ONE:
            shorten_one(world, first[s], first[s + 1], fade[s])


@device
def shorten_one(world, begin, end, part):
    """Shorten the polyline begin … end − 1 to a fraction of its length."""
    left = ZERO
    for v in range(begin + 1, end):
        left += distance(world, v - 1, v)
    left *= part
    for v in range(begin + 1, end):
        length = distance(world, v - 1, v)
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
def distance(world, v, w):
    """Return the distance between two vertices."""
    x = world[w, 0] - world[v, 0]
    y = world[w, 1] - world[v, 1]
    z = world[w, 2] - world[v, 2]
    return math.sqrt(x * x + y * y + z * z)
