"""Look-up of ambient occlusion."""

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
"""Weight of the linear part for a surface: its mean over the hemisphere, weighted by the cosine."""


@device
def corner(u, count):
    """Return the lower of two neighbouring cells, and the position between them, 0 to 1."""
    u = min(max(u, ZERO), count - ONE)
    low = min(np.int64(u), np.int64(count) - 2)
    return low, u - np.float32(low)


@function
def sky_visibility(volume, box, x, y, z, nx, ny, nz):
    """Return the visible share of the sky at a point: of the whole sphere for n = 0, or of the hemisphere around the
    unit normal n, weighted by the cosine. volume, box: of `inputs.Surround`."""
    u, v, w, place = place_of(box, x, y, z)
    share = ZERO
    for channel in range(4):
        weight = ONE
        if channel > 0:
            weight = COSINE * (nx if channel == 1 else (ny if channel == 2 else nz))
        share += weight * interpolated(volume, channel, place)
    return faded(box, u, v, w, share)


@function
def whole_sky_visibility(volume, box, x, y, z):
    """`sky_visibility` of the whole sphere, of which one channel tells."""
    u, v, w, place = place_of(box, x, y, z)
    return faded(box, u, v, w, interpolated(volume, np.int64(0), place))


@device
def place_of(box, x, y, z):
    """Return a point's place in cells, and what `interpolated` needs of it: the first of the eight cells about it, the
    cells between neighbours along y and x, and the position between them along z, y and x."""
    u = (x - box[MIDDLE_X]) * box[PER_METRE_X]
    v = (y - box[MIDDLE_Y]) * box[PER_METRE_Y]
    w = (z - box[MIDDLE_Z]) * box[PER_METRE_Z]
    i, a = corner(u, box[COUNT_X])
    j, b = corner(v, box[COUNT_Y])
    k, c = corner(w, box[COUNT_Z])
    rows = np.int64(box[COUNT_Z])
    slabs = np.int64(box[COUNT_Y]) * rows
    return u, v, w, (i * slabs + j * rows + k, rows, slabs, c, b, a)


@device
def interpolated(volume, channel, place):
    """Return a channel of cells at a place from `place_of`."""
    base, rows, slabs, c, b, a = place
    p = volume[base, channel] + c * (volume[base + 1, channel] - volume[base, channel])
    at = base + rows
    q = volume[at, channel] + c * (volume[at + 1, channel] - volume[at, channel])
    first = p + b * (q - p)
    at = base + slabs
    p = volume[at, channel] + c * (volume[at + 1, channel] - volume[at, channel])
    at += rows
    q = volume[at, channel] + c * (volume[at + 1, channel] - volume[at, channel])
    last = p + b * (q - p)
    return first + a * (last - first)


@device
def faded(box, u, v, w, share):
    """Return a visible share of the sky, more of which is visible the farther a place is outside of the cells."""
    beyond = past(u, box[COUNT_X]) / box[PER_METRE_X] + past(v, box[COUNT_Y]) / box[PER_METRE_Y]
    beyond += past(w, box[COUNT_Z]) / box[PER_METRE_Z]
    fall = box[FADE] / (box[FADE] + beyond)
    return ONE - fall * fall * (ONE - min(max(share, ZERO), ONE))


@device
def past(u, count):
    """Return by how many cells a position is outside of the box."""
    return max(max(-u, u - (count - ONE)), ZERO)
