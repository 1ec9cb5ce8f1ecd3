"""Look-up of ambient occlusion."""

from __future__ import annotations

import numpy as np

from ....jit import function, inlined
from ....simd import broadcast, floor, gather4, pointer, reduce_max
from ...common.kernels.numbers import ONE, TWO, ZERO

START, NUMBERS = np.int64(0), np.int64(4)
"""Where cells begin in memory, and the numbers of each."""
COSINE = np.float32(2.0 / 3.0)
"""Weight of the linear part for a surface: its mean over the hemisphere, weighted by the cosine."""
# The box, float32: centre of the first cell, cells a metre, and number of cells, along x, y and z.
MIDDLE_X, MIDDLE_Y, MIDDLE_Z = 0, 1, 2
PER_METRE_X, PER_METRE_Y, PER_METRE_Z = 3, 4, 5
COUNT_X, COUNT_Y, COUNT_Z = 6, 7, 8
FADE = 9
"""Distance from the box, metres, at which occlusion has fallen to a fourth."""
BOX_SIZE = 10
DENSITY = 0
"""ρ of a cell: Σ width · length / volume, 1/m."""
XX, XY, XZ, YY, YZ, ZZ = 1, 2, 3, 4, 5, 6
"""M of a cell: the same sum over t tᵀ of the unit directions t, 1/m."""
CHANNELS = 7
MEAN, SLOPE_X, SLOPE_Y, SLOPE_Z = range(4)
"""v₀ and v of the linear fit of a cell's visibility."""


@function
def sky_visibility(volume, box, x, y, z, nx, ny, nz):
    """Return the visible share of the sky at a point, as `sky_visibilities`."""
    rows = pointer(volume)
    point = broadcast(rows, x), broadcast(rows, y), broadcast(rows, z)
    return reduce_max(
        sky_visibilities(volume, box, point, (broadcast(rows, nx), broadcast(rows, ny), broadcast(rows, nz)))
    )


@inlined
def sky_visibilities(volume, box, point, normal):
    """Return the visible share of the sky at a vector of points: of the whole sphere where the normal is None or 0, or
    of the hemisphere around a unit normal, weighted by the cosine; more of it the farther a place is outside of the
    cells. volume, box: of `inputs.Surround`."""
    u = (point[0] - box[MIDDLE_X]) * box[PER_METRE_X]  # in cells
    v = (point[1] - box[MIDDLE_Y]) * box[PER_METRE_Y]
    w = (point[2] - box[MIDDLE_Z]) * box[PER_METRE_Z]
    a = min(max(ZERO, u), box[COUNT_X] - ONE)
    b = min(max(ZERO, v), box[COUNT_Y] - ONE)
    c = min(max(ZERO, w), box[COUNT_Z] - ONE)
    place = min(floor(a), box[COUNT_X] - TWO), min(floor(b), box[COUNT_Y] - TWO), min(floor(c), box[COUNT_Z] - TWO)
    a, b, c = a - place[0], b - place[1], c - place[2]
    rows = pointer(volume)
    near, far = records(rows, box, place, ZERO, c, b), records(rows, box, place, ONE, c, b)
    share = near[0] + a * (far[0] - near[0])
    if normal is not None:
        for channel in range(3):
            weight = COSINE * normal[channel]
            share = share + weight * (near[channel + 1] + a * (far[channel + 1] - near[channel + 1]))
    beyond = past(u, box[COUNT_X]) / box[PER_METRE_X] + past(v, box[COUNT_Y]) / box[PER_METRE_Y]
    beyond = beyond + past(w, box[COUNT_Z]) / box[PER_METRE_Z]
    fall = box[FADE] / (beyond + box[FADE])
    return ONE - fall * fall * (ONE - min(max(share, ZERO), ONE))


@inlined
def records(rows, box, place, i, c, b):
    """The four numbers of cells, interpolated along z and y, of slab i of the two about each place."""
    base = first_of(box, place, i, ZERO)
    p = mixed(gather4(rows, START, base, NUMBERS, ZERO), gather4(rows, NUMBERS, base, NUMBERS, ZERO), c)
    base = first_of(box, place, i, ONE)
    q = mixed(gather4(rows, START, base, NUMBERS, ZERO), gather4(rows, NUMBERS, base, NUMBERS, ZERO), c)
    return mixed(p, q, b)


@inlined
def mixed(p, q, t):
    """Four vectors between four others."""
    return (
        p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2]), p[3] + t * (q[3] - p[3]),
    )  # fmt: skip


@inlined
def first_of(box, place, i, j):
    """The cell at a place, i slabs and j rows on."""
    return ((place[0] + i) * box[COUNT_Y] + (place[1] + j)) * box[COUNT_Z] + place[2]


@inlined
def past(u, count):
    """Return by how many cells positions are outside of the box."""
    return max(max(-u, u - (count - ONE)), ZERO)
