"""Ambient occlusion looked up at points."""

from __future__ import annotations

import numpy as np

from ....jit import device, function
from .occlusion_columns import (
    COUNT_X,
    COUNT_Y,
    COUNT_Z,
    FADE,
    MIDDLE_X,
    MIDDLE_Y,
    MIDDLE_Z,
    PER_METRE_X,
    PER_METRE_Y,
    PER_METRE_Z,
)

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
COSINE = np.float32(2.0 / 3.0)
"""Share of the linear part of what is seen that counts for a surface, which weighs it by the cosine."""


@device
def corner(u, count):
    """The lower of two neighbouring cells, and the part of the way to the other."""
    u = min(max(u, ZERO), count - ONE)
    low = min(np.int64(u), np.int64(count) - 2)
    return low, u - np.float32(low)


@function
def seen(volume, box, x, y, z, nx, ny, nz):
    """Share of the light from everywhere that strands and solids leave a point: of the sphere with n = 0, for a
    strand, or of a surface's half, weighed by the cosine to its normal n."""
    u = (x - box[MIDDLE_X]) * box[PER_METRE_X]
    v = (y - box[MIDDLE_Y]) * box[PER_METRE_Y]
    w = (z - box[MIDDLE_Z]) * box[PER_METRE_Z]
    i, a = corner(u, box[COUNT_X])
    j, b = corner(v, box[COUNT_Y])
    k, c = corner(w, box[COUNT_Z])
    rows = np.int64(box[COUNT_Z])
    slabs = np.int64(box[COUNT_Y]) * rows
    base = i * slabs + j * rows + k
    share = ZERO
    for channel in range(4):
        weight = ONE
        if channel > 0:
            weight = COSINE * (nx if channel == 1 else (ny if channel == 2 else nz))
        p = volume[base, channel] + c * (volume[base + 1, channel] - volume[base, channel])
        at = base + rows
        q = volume[at, channel] + c * (volume[at + 1, channel] - volume[at, channel])
        first = p + b * (q - p)
        at = base + slabs
        p = volume[at, channel] + c * (volume[at + 1, channel] - volume[at, channel])
        at += rows
        q = volume[at, channel] + c * (volume[at + 1, channel] - volume[at, channel])
        last = p + b * (q - p)
        share += weight * (first + a * (last - first))
    beyond = past(u, box[COUNT_X]) / box[PER_METRE_X] + past(v, box[COUNT_Y]) / box[PER_METRE_Y]
    beyond += past(w, box[COUNT_Z]) / box[PER_METRE_Z]
    fall = box[FADE] / (box[FADE] + beyond)
    return ONE - fall * fall * (ONE - min(max(share, ZERO), ONE))


@device
def past(u, count):
    """Cells by which a place is beyond the box."""
    return max(max(-u, u - (count - ONE)), ZERO)
