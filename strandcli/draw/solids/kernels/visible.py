"""Which solid is in front at places of the screen: the keys of a z-buffer of solids."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange
from ....simd.local import local_float64
from ....solids.kernels import box, built_in, capsule, custom, plane, sphere
from ....solids.kernels.built_in import device_if_built_in
from ....solids.kernels.custom import RAYS, put_ray
from ...common.kernels.keys import EMPTY, FIRST, LOW, SHIFT
from ...common.kernels.numbers import HALF, INF, ONE, ZERO
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, DEPTH_RANGE, FOCAL, NEAR_PLANE, PERSPECTIVE
from .rays import ray

LEFT, RIGHT, TOP, BOTTOM = range(4)
"""Columns of a solid's screen bounds: pixels, right and bottom exclusive."""
# Rows of a batch of up to W rays, float32: place on the screen, origin, direction, and where a solid is met in units of
# the direction.
X, Y, OX, OY, OZ, DX, DY, DZ, MET = (row * W for row in range(9))
BATCH = 9 * W
AT_OX, AT_OY, AT_OZ, AT_DX, AT_DY, AT_DZ, AT_MET = (np.uint64(row) for row in (OX, OY, OZ, DX, DY, DZ, MET))
"""The same rows, for indices that cannot be negative."""


@parallel
def find(spots, only, width, view, solids, frames, keys):
    """Write the key of the solid that is in front at each place, or `keys.EMPTY`, to keys (n,) uint64.

    spots (n, 2) float32: columns and rows on the screen, or (0, 2): the middles of the pixels of a picture so wide;
    only (n,) int64: number of the one solid that is looked for, or (0,): all are; frames (m, 4) int64: screen bounds of
    each solid, with the columns above.
    """
    together = W if spots.shape[0] > 0 else width  # places of a task: of a picture, a row of its pixels
    for one in prange((keys.shape[0] + together - 1) // together):
        task = np.int64(one)
        work = np.empty(BATCH, np.float32)
        for begin in range(task * together, min((task + 1) * together, keys.shape[0]), W):
            count = min(W, (task + 1) * together - begin, keys.shape[0] - begin)
            corner = begin - task * together, task
            find_batch(work, begin, count, corner, spots, only, view, solids, frames, keys)


@device
def find_batch(work, begin, count, corner, spots, only, view, solids, frames, keys):
    """`find` of `count` places from number `begin` on, those of pixels from a column and a row, `corner`, on."""
    aimed = False
    left, right, top, bottom = place(work, begin, count, corner, spots)
    for j in range(count):
        keys[begin + j] = EMPTY
    for m in range(frames.shape[0]):
        across = right >= np.float32(frames[m, LEFT]) and left <= np.float32(frames[m, RIGHT])
        if not (across and bottom >= np.float32(frames[m, TOP]) and top <= np.float32(frames[m, BOTTOM])):
            continue
        if not aimed:
            aim(work, count, view)
            aimed = True
        meet_batch(work, count, solids, m)
        for j in range(np.uint64(count)):
            if only.shape[0] == 0 or only[np.uint64(begin) + j] == m:
                key = key_at(work[AT_MET + j], view, FIRST + np.uint64(m))
                keys[np.uint64(begin) + j] = min(keys[np.uint64(begin) + j], key)


@device
def place(work, begin, count, corner, spots):
    """Store the rows X and Y of the places of a batch, and return the sides of the box about them."""
    if spots.shape[0] == 0:
        x, y = np.float32(corner[0]) + HALF, np.float32(corner[1]) + HALF
        for j in range(count):
            work[X + j], work[Y + j] = x + np.float32(j), y
        return x, x + np.float32(count), y, y
    left, right, top, bottom = INF, -INF, INF, -INF
    for j in range(count):
        x, y = spots[begin + j, 0], spots[begin + j, 1]
        work[X + j], work[Y + j] = x, y
        left, right, top, bottom = min(left, x), max(right, x), min(top, y), max(bottom, y)
    return left, right, top, bottom


@device
def aim(work, count, view):
    """Store origins and directions of the rays through the places of a batch."""
    for j in range(np.uint64(count)):
        x, y = work[np.uint64(X) + j], work[np.uint64(Y) + j]
        ox, oy, oz, dx, dy, dz = ray(view, (x - view[AXIS_X]) / view[FOCAL], (view[AXIS_Y] - y) / view[FOCAL])
        work[AT_OX + j], work[AT_OY + j], work[AT_OZ + j] = ox, oy, oz
        work[AT_DX + j], work[AT_DY + j], work[AT_DZ + j] = dx, dy, dz


@device
def meet_batch(work, count, solids, m):
    """Store the depths at which the rays of a batch meet solid number m."""
    own = m - built_in.count(solids)  # number among those without kernels of their own
    if own < 0:
        meet_built_in(solids, m, work, np.uint64(count))
        return
    beams, found = local_float64(), local_float64()
    for first in range(0, count, RAYS):
        for k in range(RAYS):
            put_ray(beams, k, ray_at(work, np.uint64(min(first + k, count - 1))))
        custom.trace_rays(solids, own, beams, found)
        for k in range(min(RAYS, count - first)):
            work[MET + first + k] = found[k]


@device_if_built_in(lambda solids, m, work, count: None)
def meet_built_in(solids, m, work, count):
    """`meet_batch` of a solid that has kernels of its own. A loop for each shape has no branches, so LLVM makes vectors
    of it."""
    spheres, capsules, planes = solids.spheres, solids.capsules, solids.planes
    if m < spheres.shape[0]:
        for j in range(count):
            ox, oy, oz, dx, dy, dz = ray_at(work, j)
            work[AT_MET + j] = sphere.meet(spheres, m, ox, oy, oz, dx, dy, dz)
        return
    m -= spheres.shape[0]
    if m < capsules.shape[0]:
        for j in range(count):
            ox, oy, oz, dx, dy, dz = ray_at(work, j)
            work[AT_MET + j] = capsule.meet(capsules, m, ox, oy, oz, dx, dy, dz)
        return
    m -= capsules.shape[0]
    if m < planes.shape[0]:
        for j in range(count):
            ox, oy, oz, dx, dy, dz = ray_at(work, j)
            work[AT_MET + j] = plane.meet(planes, m, ox, oy, oz, dx, dy, dz)
        return
    m -= planes.shape[0]
    for j in range(count):
        ox, oy, oz, dx, dy, dz = ray_at(work, j)
        work[AT_MET + j] = box.meet(solids.boxes, m, ox, oy, oz, dx, dy, dz)


@device
def ray_at(work, j):
    """Return origin and direction of ray number j of a batch."""
    return (
        work[AT_OX + j], work[AT_OY + j], work[AT_OZ + j],
        work[AT_DX + j], work[AT_DY + j], work[AT_DZ + j],
    )  # fmt: skip


@device
def key_at(t, view, identity):
    """Return the z-buffer key of a solid at depth t, metres, or `keys.EMPTY` if t is not in front of the near plane."""
    flat = ONE - view[PERSPECTIVE]
    # depths behind an orthographic view's range are clamped to its end
    q = (ONE - flat) / t + flat * max(ONE - (t - view[NEAR_PLANE]) * (ONE / view[DEPTH_RANGE]), ZERO)
    key = ((LOW - np.uint64(np.float32(q).view(np.uint32))) << SHIFT) | identity
    return key if view[NEAR_PLANE] < t < INF else EMPTY
