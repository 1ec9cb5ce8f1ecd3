"""Shadows of solids at a batch of points: hard ones, and soft ones of lights that have a size (see `penumbra`)."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, function, inlined
from ....simd import lane_count, load, load3, pointer, store
from ....solids.kernels import custom
from ....solids.kernels import plane as plane_rays
from ....solids.kernels import sphere as sphere_rays
from ....solids.kernels.built_in import device_if_built_in
from ....solids.kernels.outside import count
from ....solids.shapes import capsule, plane, sphere
from ...common.kernels import batch as row
from ...common.kernels.light_columns import KIND, LIGHT_SIZE
from ...common.kernels.numbers import HALF, ONE, ZERO
from ...solids.kernels import rays
from . import penumbra


@device
def hard_shadows(work, n, solids, skin):
    """Set the rows `ARRIVES` of the first n points of a batch to 0 where a solid occludes the light.

    Rows of `batch`; solids: `strandcli.solids.Solids`; skin: as in `rays.visibility`.
    """
    past_spheres(solids, work, n, skin)
    past_planes(solids, work, n, skin)
    if count(solids) > solids.spheres.shape[0] + solids.planes.shape[0]:
        for k in range(n):
            if work[row.ARRIVES + k] > ZERO:
                x, y, z = row.vector_at(work, row.X, k)
                lx, ly, lz = row.vector_at(work, row.LX, k)
                work[row.ARRIVES + k] *= rays.visibility(solids, x, y, z, lx, ly, lz, work[row.REACH + k], skin)


@device_if_built_in(lambda solids, work, n, skin: None)
def past_spheres(solids, work, n, skin):
    """Set the rows `ARRIVES` to 0 where a sphere occludes the light."""
    for s in range(solids.spheres.shape[0]):
        for k in range(n):
            x, y, z = row.vector_at(work, row.X, k)
            lx, ly, lz = row.vector_at(work, row.LX, k)
            work[row.ARRIVES + k] *= sphere_rays.visibility(
                solids.spheres, s, x, y, z, lx, ly, lz, work[row.REACH + k], skin
            )


@device_if_built_in(lambda solids, work, n, skin: None)
def past_planes(solids, work, n, skin):
    """Set the rows `ARRIVES` to 0 where a plane occludes the light."""
    for s in range(solids.planes.shape[0]):
        for k in range(n):
            x, y, z = row.vector_at(work, row.X, k)
            lx, ly, lz = row.vector_at(work, row.LX, k)
            t = plane_rays.meet(solids.planes, s, x + skin * lx, y + skin * ly, z + skin * lz, lx, ly, lz)
            hides = (skin < t) & (t < work[row.REACH + k])
            work[row.ARRIVES + k] = ZERO if hides else work[row.ARRIVES + k]


@function
def soft_shadows(work, n, lights, i, solids, skin):
    """Multiply the rows `ARRIVES` of the first n points of a batch by the visibility of light number i past solids.

    Rows of `batch`; solids: `strandcli.solids.Solids`; skin: depth below a surface that counts as on it,
    metres.
    """
    size = lights[i, LIGHT_SIZE]
    point = lights[i, KIND]
    for k in range(n):
        # the sine of the light's angular radius
        radius = max(min(size / work[row.REACH + k], ONE) if point > ZERO else size, penumbra.SHARP)
        work[row.RADIUS + k] = radius
        # without incoming light the point counts as fully occluded
        work[row.LEAST + k] = radius if work[row.ARRIVES + k] > ZERO else -radius
    past_built_in(solids, work, n, skin)
    by_distances(work, n, solids, skin, skin)
    for k in range(n):
        work[row.ARRIVES + k] *= penumbra.share(work[row.LEAST + k], work[row.RADIUS + k])


@device_if_built_in(lambda solids, work, n, skin: None)
def past_built_in(solids, work, n, skin):
    """Reduce the rows `LEAST` to the sines of the angles to solids of the four shapes."""
    for m in range(solids.spheres.shape[0]):
        cx, cy, cz = solids.spheres[m, sphere.X], solids.spheres[m, sphere.Y], solids.spheres[m, sphere.Z]
        r = solids.spheres[m, sphere.RADIUS] - skin
        for k in range(n):
            x, y, z = lifted(work, k, skin)
            lx, ly, lz = row.vector_at(work, row.LX, k)
            least = penumbra.ball(r, cx - x, cy - y, cz - z, lx, ly, lz, work[row.REACH + k])
            work[row.LEAST + k] = min(work[row.LEAST + k], least)
    for m in range(solids.capsules.shape[0]):
        by_capsule(work, n, solids.capsules, m, skin)
    for m in range(solids.planes.shape[0]):
        nx, ny, nz = solids.planes[m, plane.X], solids.planes[m, plane.Y], solids.planes[m, plane.Z]
        height = solids.planes[m, plane.HEIGHT]
        for k in range(n):
            x, y, z = lifted(work, k, skin)
            over = nx * x + ny * y + nz * z - height
            lx, ly, lz = row.vector_at(work, row.LX, k)
            least = over / work[row.REACH + k] + (nx * lx + ny * ly + nz * lz)
            work[row.LEAST + k] = min(work[row.LEAST + k], least if over >= ZERO else penumbra.CLEAR)
    for m in range(solids.boxes.shape[0]):
        for k in range(n):
            if work[row.LEAST + k] > -work[row.RADIUS + k]:
                least = penumbra.box(solids.boxes, m, ray_of(work, k, skin), skin, work[row.RADIUS + k])
                work[row.LEAST + k] = min(work[row.LEAST + k], least)


@inlined
def lifted(work, k, skin):
    """Return point number k, moved by `skin` toward the light."""
    x, y, z = row.vector_at(work, row.X, k)
    lx, ly, lz = row.vector_at(work, row.LX, k)
    return x + skin * lx, y + skin * ly, z + skin * lz


@inlined
def ray_of(work, k, skin):
    """Return the `penumbra.LightRay` of point number k, moved by `skin` toward the light."""
    x, y, z = lifted(work, k, skin)
    lx, ly, lz = row.vector_at(work, row.LX, k)
    return penumbra.LightRay(x, y, z, lx, ly, lz, work[row.REACH + k])


@device
def by_capsule(work, n, capsules, m, skin):
    """Reduce the rows `LEAST` to the sines of the angles to the edge of row m of the capsules.

    A loop without branches finds the points that a ball about the capsule may shade; the costly part is for them alone.
    """
    r = capsules[m, capsule.RADIUS] - skin
    if r <= ZERO:
        return
    bx, by, bz = capsules[m, capsule.AXIS_X], capsules[m, capsule.AXIS_Y], capsules[m, capsule.AXIS_Z]
    cx, cy, cz = (
        capsules[m, capsule.X] + HALF * bx,
        capsules[m, capsule.Y] + HALF * by,
        capsules[m, capsule.Z] + HALF * bz,
    )
    around = r + HALF * np.sqrt(bx * bx + by * by + bz * bz)
    for k in range(n):
        x, y, z = lifted(work, k, skin)
        lx, ly, lz = row.vector_at(work, row.LX, k)
        radius = work[row.RADIUS + k]
        free = penumbra.aside(around, cx - x, cy - y, cz - z, lx, ly, lz, radius)
        work[row.ASKED + k] = ZERO if free | (work[row.LEAST + k] <= -radius) else ONE
    for k in range(n):
        if work[row.ASKED + k] > ZERO:
            least = penumbra.capsule(r, (cx, cy, cz), (bx, by, bz), ray_of(work, k, skin), work[row.RADIUS + k])
            work[row.LEAST + k] = min(work[row.LEAST + k], least)


@device
def by_distances(work, n, solids, lift, skin):
    """Reduce the rows `LEAST` to the sines of the angles between lights and custom solids, as seen
    from points moved by `lift` metres toward the lights. Rows of `batch`: positions, lights, `RADIUS`."""
    rows = pointer(work)
    lanes = lane_count(rows)
    for k in range(n, -(-n // (2 * lanes)) * 2 * lanes):  # nothing to look for
        work[row.LEAST + k] = ZERO
        work[row.RADIUS + k] = ZERO
    for m in range(custom.count(solids)):
        for k in range(0, n, 2 * lanes):
            one, two = begun(rows, k, solids, m, lift, skin), begun(rows, k + lanes, solids, m, lift, skin)
            least, second = custom.walk(solids, m, one, two)
            store(rows, row.LEAST + k, least)
            store(rows, row.LEAST + k + lanes, second)


@inlined
def begun(rows, k, solids, m, lift, skin):
    """Return what `custom.walk` takes of the vector of rays from number k on."""
    lx, ly, lz = direction = load3(rows, row.LX + k, W)
    x, y, z = load3(rows, row.X + k, W)
    light = load(rows, row.REACH + k), load(rows, row.RADIUS + k), skin
    along, t, end = custom.begin_walk(solids, m, (x + lx * lift, y + ly * lift, z + lz * lift), direction, light)
    return along, t, end, load(rows, row.LEAST + k), light
