"""Level of detail strand by strand (see `strandcli.draw.detail`)."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import parallel, prange

ZERO = np.float32(0.0)


@parallel
def choose(positions, ids, total, eye, near, least, band, fade, wider):
    """What is drawn of each strand, and by how much wider.

    positions (blocks, n + 1, 3 W) float32; ids (strands,) int32: places in the order of all `total`, or None where they
    are 0, 1, …; eye (3,) float64 metres, or None where `near` is the share itself; near: distance up to which all are
    kept; least: smallest share; band: see `strandcli.draw.detail`; fade, wider (strands,) float32.
    """
    for s in prange(fade.shape[0]):
        k = near
        if eye is not None:
            square = 0.0
            for c in range(3):
                d = positions[s // W, 1, c * W + s % W] - eye[c]
                square += d * d
            k = near / max(math.sqrt(square), 1e-30)
        k = min(max(k, least), 1.0)
        wide = max(band * k, 1.0 / total)
        place = ((s if ids is None else ids[s]) + 0.5) / total
        fade[s] = min(max((k + wide - place) / wide, 0.0), 1.0)
        beyond = max(k + wide - 1.0, 0.0)
        wider[s] = 1.0 / (k + 0.5 * wide - 0.5 * beyond * beyond / wide)


@parallel
def shorten(first, world, fade):
    """Strands of which a part is left keep the part next to their root: all beyond becomes one point.

    first (S + 1,) int64; world (V, 3) metres; fade (S,).
    """
    for s in prange(fade.shape[0]):
        begin = first[s]
        end = first[s + 1]
        if fade[s] < np.float32(1.0) and end > begin:
            place = fade[s] * np.float32(end - begin - 1)
            low = begin + min(np.int64(place), max(end - begin - 2, 0))
            part = place - np.float32(low - begin)
            high = min(low + 1, end - 1)
            for c in range(3):
                world[high, c] = world[low, c] + part * (world[high, c] - world[low, c])
            for v in range(high + 1, end):
                for c in range(3):
                    world[v, c] = world[high, c]
