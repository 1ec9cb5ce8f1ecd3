"""Soft shadows of solids at a batch of points, vectorised over points (see `penumbra`).

For each solid a loop over all points discards those from which the whole light is certainly visible. The others are
compacted into a list, and the costly part runs on the list alone, vectorised too.
"""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, function, inlined
from ....solids.kernels import other
from ....solids.kernels.built_in import device_if_built_in
from ....solids.shapes import capsule, plane, sphere
from ...common.kernels import batch as row
from ...common.kernels.light_columns import KIND, LIGHT_SIZE
from ...common.kernels.numbers import HALF, ONE, ZERO
from . import penumbra
from .soft_distances import by_distances, by_distances_of_some

FEW = 2
"""Capsules that are looked at without asking first whether any of them may be seen before the light."""
MOVED = 8
"""Rows from `LIST` on that describe a listed point."""


@function
def soft_shadows(work, n, lights, i, solids, skin, free):
    """Multiply the rows `ARRIVES` of the first n points of a batch by the visibility of light number i past solids.

    Rows of `batch`; solids: `strandcli.solids.Solids`; skin: depth below a surface that counts as on it,
    metres; free: `FreeWays`, without rows for points that these do not know.
    """
    size = lights[i, LIGHT_SIZE]
    point = lights[i, KIND]
    for k in range(n):
        radius = penumbra.seen_from(size, point, work[row.REACH + k])
        work[row.RADIUS + k] = radius
        # without incoming light the point counts as fully occluded
        work[row.LEAST + k] = radius if work[row.ARRIVES + k] > ZERO else -radius
    past_built_in(solids, work, n, skin)
    if other.count(solids) > 0:
        if other.takes_vectors(solids) and free.depths.shape[0] > 0:
            by_distances_of_some(work, n, i, solids, skin, free)
        elif other.takes_vectors(solids):
            by_distances(work, n, solids, skin, skin)
        else:
            by_distance(work, n, solids, skin)
    for k in range(n):
        work[row.ARRIVES + k] *= penumbra.share(work[row.LEAST + k], work[row.RADIUS + k])


@device_if_built_in(lambda solids, work, n, skin: None)
def past_built_in(solids, work, n, skin):
    """Reduce the rows `LEAST` to the sines of the angles to solids of the four shapes."""
    for m in range(solids.spheres.shape[0]):
        x, y, z = solids.spheres[m, sphere.X], solids.spheres[m, sphere.Y], solids.spheres[m, sphere.Z]
        by_ball(work, n, x, y, z, solids.spheres[m, sphere.RADIUS] - skin, skin)
    if solids.capsules.shape[0] <= FEW or any_may_see(work, n, solids.capsules, skin):
        for m in range(solids.capsules.shape[0]):
            by_capsule(work, n, solids.capsules, m, skin)
    for m in range(solids.planes.shape[0]):
        x, y, z = solids.planes[m, plane.X], solids.planes[m, plane.Y], solids.planes[m, plane.Z]
        by_plane(work, n, x, y, z, solids.planes[m, plane.HEIGHT], skin)
    for m in range(solids.boxes.shape[0]):
        for k in range(n):
            if work[row.LEAST + k] > -work[row.RADIUS + k]:
                x, y, z = lifted(work, k, skin)
                lx, ly, lz = row.vector_at(work, row.LX, k)
                ray = penumbra.LightRay(x, y, z, lx, ly, lz, work[row.REACH + k])
                least = penumbra.box(solids.boxes, m, ray, skin, work[row.RADIUS + k])
                work[row.LEAST + k] = min(work[row.LEAST + k], least)


@device
def any_may_see(work, n, capsules, skin):
    """Return whether there is a point from which any of the capsules may cover the light: a ball about all of them
    does."""
    x = y = z = ZERO
    for m in range(capsules.shape[0]):
        x += capsules[m, capsule.X] + HALF * capsules[m, capsule.AXIS_X]
        y += capsules[m, capsule.Y] + HALF * capsules[m, capsule.AXIS_Y]
        z += capsules[m, capsule.Z] + HALF * capsules[m, capsule.AXIS_Z]
    per = ONE / np.float32(capsules.shape[0])
    x, y, z = per * x, per * y, per * z
    r = ZERO
    for m in range(capsules.shape[0]):
        ax, ay, az = capsules[m, capsule.AXIS_X], capsules[m, capsule.AXIS_Y], capsules[m, capsule.AXIS_Z]
        ax, ay, az = HALF * ax, HALF * ay, HALF * az
        dx, dy, dz = capsules[m, capsule.X] + ax - x, capsules[m, capsule.Y] + ay - y, capsules[m, capsule.Z] + az - z
        half = math.sqrt(ax * ax + ay * ay + az * az)
        r = max(r, capsules[m, capsule.RADIUS] + half + math.sqrt(dx * dx + dy * dy + dz * dz))
    found = np.int32(0)
    for k in range(n):
        px, py, pz = lifted(work, k, skin)
        lx, ly, lz = row.vector_at(work, row.LX, k)
        radius = work[row.RADIUS + k]
        free = penumbra.aside(r, x - px, y - py, z - pz, lx, ly, lz, radius)
        found |= np.int32(ZERO if free | (work[row.LEAST + k] <= -radius) else ONE)
    return found != 0


@inlined
def lifted(work, k, skin):
    """Return point number k, moved by `skin` toward the light."""
    x, y, z = row.vector_at(work, row.X, k)
    lx, ly, lz = row.vector_at(work, row.LX, k)
    return x + skin * lx, y + skin * ly, z + skin * lz


@device
def by_ball(work, n, cx, cy, cz, r, skin):
    """Reduce the rows `LEAST` to the sines of the angles to the edge of a ball of centre c and radius r, metres."""
    for k in range(n):
        x, y, z = lifted(work, k, skin)
        lx, ly, lz = row.vector_at(work, row.LX, k)
        least = penumbra.ball(r, cx - x, cy - y, cz - z, lx, ly, lz, work[row.REACH + k])
        work[row.LEAST + k] = min(work[row.LEAST + k], least)


@device
def by_plane(work, n, nx, ny, nz, height, skin):
    """Reduce the rows `LEAST` to the sines of the angles to a plane of unit normal n at `height` from the origin."""
    for k in range(n):
        x, y, z = lifted(work, k, skin)
        over = nx * x + ny * y + nz * z - height
        lx, ly, lz = row.vector_at(work, row.LX, k)
        up = nx * lx + ny * ly + nz * lz
        least = over / work[row.REACH + k] + up
        work[row.LEAST + k] = min(work[row.LEAST + k], least if over >= ZERO else penumbra.CLEAR)


@device
def by_distance(work, n, solids, skin):
    """Reduce the rows `LEAST` to the sines of the angles to solids without kernels of their own."""
    for k in range(n):
        if work[row.LEAST + k] > -work[row.RADIUS + k]:
            x, y, z = lifted(work, k, skin)
            light = work[row.REACH + k], work[row.RADIUS + k], skin
            least = other.lowest_sine(solids, x, y, z, row.vector_at(work, row.LX, k), light)
            work[row.LEAST + k] = min(work[row.LEAST + k], least)


@device
def by_capsule(work, n, capsules, m, skin):
    """Reduce the rows `LEAST` to the sines of the angles to the edge of row m of the capsules."""
    r = capsules[m, capsule.RADIUS] - skin
    if r <= ZERO:
        return
    ax, ay, az = capsules[m, capsule.X], capsules[m, capsule.Y], capsules[m, capsule.Z]
    bx, by, bz = capsules[m, capsule.AXIS_X], capsules[m, capsule.AXIS_Y], capsules[m, capsule.AXIS_Z]
    bb = bx * bx + by * by + bz * bz
    around = r + HALF * math.sqrt(bb)
    found = np.int32(0)
    for k in range(n):
        x, y, z = lifted(work, k, skin)
        lx, ly, lz = row.vector_at(work, row.LX, k)
        radius = work[row.RADIUS + k]
        free = penumbra.aside(around, ax - x + HALF * bx, ay - y + HALF * by, az - z + HALF * bz, lx, ly, lz, radius)
        asked = ZERO if free | (work[row.LEAST + k] <= -radius) else ONE
        work[row.ASKED + k] = asked
        found |= np.int32(asked)
    if found == 0:
        return
    count = np.int64(0)
    for k in range(n):
        work[row.LIST + count] = np.float32(k)
        count += np.int64(work[row.ASKED + k])
    for j in range(count):
        k = np.int64(work[row.LIST + j])
        x, y, z = lifted(work, k, skin)
        row.set_vector(work, row.WX, j, (ax - x, ay - y, az - z))
        row.set_vector(work, row.DX, j, row.vector_at(work, row.LX, k))
        work[row.END + j] = work[row.REACH + k]
        work[row.NEAR + j] = work[row.RADIUS + k]
    for j in range(count):
        wx, wy, wz = row.vector_at(work, row.WX, j)
        lx, ly, lz = row.vector_at(work, row.DX, j)
        free, s = penumbra.nearest(r, wx, wy, wz, (bx, by, bz, bb), lx, ly, lz, work[row.NEAR + j])
        least = on_axis(work, j, r, bx, by, bz, s)
        work[row.FAR + j] = penumbra.CLEAR if free else least
        work[row.ASKED + j] = ZERO if free | (least <= -work[row.NEAR + j]) else ONE
    search(work, compact(work, count), r, bx, by, bz)


@device
def compact(work, count):
    """Store the results of the listed points, keep only those that need a search in the list; return their number."""
    left = np.int64(0)
    for j in range(count):
        k = np.int64(work[row.LIST + j])
        work[row.LEAST + k] = min(work[row.LEAST + k], work[row.FAR + j])
        for moved in range(row.LIST, row.LIST + MOVED * W, W):
            work[moved + left] = work[moved + j]
        left += np.int64(work[row.ASKED + j])
    return left


@inlined
def on_axis(work, j, r, bx, by, bz, s):
    """Return `penumbra.ball` of the ball at position s of the axis, for listed point j."""
    wx, wy, wz = row.vector_at(work, row.WX, j)
    lx, ly, lz = row.vector_at(work, row.DX, j)
    return penumbra.ball(r, wx + s * bx, wy + s * by, wz + s * bz, lx, ly, lz, work[row.END + j])


@device
def search(work, count, r, bx, by, bz):
    """Find the least `penumbra.ball` on the axis for all listed points by golden-section search, and reduce their
    `LEAST`: a capsule is convex, so there is a single minimum."""
    if count == 0:
        return
    for j in range(count):
        work[row.LOW + j] = ZERO
        work[row.HIGH + j] = ONE
        work[row.NEAR + j] = ONE - penumbra.CLOSER * (ONE - ZERO)
        work[row.FAR + j] = ZERO + penumbra.CLOSER * (ONE - ZERO)
    for j in range(count):
        work[row.AT_NEAR + j] = on_axis(work, j, r, bx, by, bz, work[row.NEAR + j])
        work[row.AT_FAR + j] = on_axis(work, j, r, bx, by, bz, work[row.FAR + j])
    for _ in range(penumbra.ALONG):
        for j in range(count):
            low, near, far, high = work[row.LOW + j], work[row.NEAR + j], work[row.FAR + j], work[row.HIGH + j]
            at_near, at_far = work[row.AT_NEAR + j], work[row.AT_FAR + j]
            nearer = at_near < at_far
            low = low if nearer else near
            high = far if nearer else high
            step = penumbra.CLOSER * (high - low)
            s = high - step if nearer else low + step
            found = on_axis(work, j, r, bx, by, bz, s)
            work[row.LOW + j] = low
            work[row.HIGH + j] = high
            work[row.NEAR + j] = s if nearer else far
            work[row.FAR + j] = near if nearer else s
            work[row.AT_NEAR + j] = found if nearer else at_far
            work[row.AT_FAR + j] = at_near if nearer else found
    for j in range(count):
        k = np.int64(work[row.LIST + j])
        work[row.LEAST + k] = min(work[row.LEAST + k], min(work[row.AT_NEAR + j], work[row.AT_FAR + j]))
