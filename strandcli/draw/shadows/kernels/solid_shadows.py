"""Shadows of solids at a batch of points: hard ones, and soft ones of lights that have a size (see `penumbra`)."""

from __future__ import annotations

import numpy as np

from ....jit import device, function, inlined
from ....solids.kernels import other
from ....solids.kernels.built_in import device_if_built_in
from ....solids.shapes import capsule, plane, sphere
from ...common.kernels import batch as row
from ...common.kernels.light_columns import KIND, LIGHT_SIZE
from ...common.kernels.numbers import HALF, ONE, ZERO
from ...solids.kernels import rays
from . import penumbra
from .soft_distances import by_distances


@device
def hard_shadows(work, n, solids, skin):
    """Set the rows `ARRIVES` of the first n points of a batch to 0 where a solid occludes the light.

    Rows of `batch`; solids: `strandcli.solids.Solids`; skin: as in `rays.visibility`.
    """
    for k in range(n):
        if work[row.ARRIVES + k] > ZERO:
            x, y, z = row.vector_at(work, row.X, k)
            lx, ly, lz = row.vector_at(work, row.LX, k)
            work[row.ARRIVES + k] *= rays.visibility(solids, x, y, z, lx, ly, lz, work[row.REACH + k], skin)


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
    if other.count(solids) > 0:
        if other.takes_vectors(solids):
            by_distances(work, n, solids, skin, skin)
        else:
            for k in range(n):
                if work[row.LEAST + k] > -work[row.RADIUS + k]:
                    x, y, z = lifted(work, k, skin)
                    light = work[row.REACH + k], work[row.RADIUS + k], skin
                    least = other.lowest_sine(solids, x, y, z, row.vector_at(work, row.LX, k), light)
                    work[row.LEAST + k] = min(work[row.LEAST + k], least)
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
