"""Shadows of solids at a batch of points: hard ones, and soft ones of lights that have a size (see `penumbra`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....constants import W
from ....jit import device, function, inlined
from ....simd import lane_count, load, load3, pointer, store, where
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
    if custom.count(solids) > 0:
        if custom.takes_vectors(solids):
            by_distances(work, n, solids, skin, skin)
        else:
            for k in range(n):
                if work[row.LEAST + k] > -work[row.RADIUS + k]:
                    x, y, z = lifted(work, k, skin)
                    light = work[row.REACH + k], work[row.RADIUS + k], skin
                    least = custom.lowest_sine(solids, x, y, z, row.vector_at(work, row.LX, k), light)
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


FEW, ALL = np.int64(6), np.int64(1 << 40)
"""Steps that all rays take at the most, and listed ones."""


class Rays(NamedTuple):
    """Rows of rays: numbers of the first of three or of the only one."""

    point: np.int64
    direction: np.int64
    """Unit vector to the light's centre."""
    reach: np.int64
    """Distance to it, metres."""
    radius: np.int64
    """Sine of the light's angular radius."""
    least: np.int64
    """Sine of the least angle to an edge so far."""
    place: np.int64
    """How far the ray has come, metres."""


OWN = Rays(
    np.int64(row.X),
    np.int64(row.LX),
    np.int64(row.REACH),
    np.int64(row.RADIUS),
    np.int64(row.LEAST),
    np.int64(row.AT_NEAR),
)
LISTED = Rays(
    np.int64(row.WX), np.int64(row.DX), np.int64(row.END), np.int64(row.NEAR), np.int64(row.HIGH), np.int64(row.FAR)
)


@device
def by_distances(work, n, solids, lift, skin):
    """Reduce the rows `LEAST` to the sines of the angles between lights and solids that have distances of vectors, as
    seen from points moved by `lift` metres toward the lights. Rows of `batch`: positions, lights, `RADIUS`."""
    for m in range(custom.count(solids)):
        for k in range(n):
            work[row.AT_NEAR + k] = ZERO
        go(work, n, OWN, solids, m, (lift, skin), FEW)
        count = np.int64(0)
        for k in range(n):
            work[row.LIST + count] = np.float32(k)
            count += np.int64(work[row.ASKED + k])
        if count > 0:
            for j in range(count):
                k = np.int64(work[row.LIST + j])
                row.set_vector(work, row.WX, j, row.vector_at(work, row.X, k))
                row.set_vector(work, row.DX, j, row.vector_at(work, row.LX, k))
                work[row.END + j], work[row.NEAR + j] = work[row.REACH + k], work[row.RADIUS + k]
                work[row.HIGH + j], work[row.FAR + j] = work[row.LEAST + k], work[row.AT_NEAR + k]
            go(work, count, LISTED, solids, m, (lift, skin), ALL)
            for j in range(count):
                work[row.LEAST + np.int64(work[row.LIST + j])] = work[row.HIGH + j]


@device
def go(work, n, at, solids, m, lift_and_skin, most):
    """Let n rays go on through solid number m, in so many steps at the most; `ASKED` is 1 where they are not done. at:
    `Rays`; lift_and_skin: of `by_distances`."""
    rows = pointer(work)
    lanes = lane_count(rows)
    for k in range(n, -(-n // (2 * lanes)) * 2 * lanes):  # nothing to look for
        work[at.least + k] = ZERO
        work[at.radius + k] = ZERO
    for k in range(0, n, 2 * lanes):
        some = begun(rows, k, at, solids, m, lift_and_skin)
        if k + lanes >= n:
            t, least = custom.walk_alone(solids, m, some, most)
            keep(rows, k, at, t, least, some)
            break
        second = begun(rows, k + lanes, at, solids, m, lift_and_skin)
        s, s_least, t, t_least = custom.walk(solids, m, some, second, most)
        keep(rows, k, at, s, s_least, some)
        keep(rows, k + lanes, at, t, t_least, second)


@inlined
def begun(rows, k, at, solids, m, lift_and_skin):
    """Return what `custom.walk` takes of a vector of rays."""
    lift, skin = lift_and_skin
    lx, ly, lz = direction = load3(rows, at.direction + k, W)
    x, y, z = load3(rows, at.point + k, W)
    light = load(rows, at.reach + k), load(rows, at.radius + k), skin
    along, t, end = custom.begin_walk(solids, m, (x + lx * lift, y + ly * lift, z + lz * lift), direction, light)
    return along, max(t, load(rows, at.place + k)), end, load(rows, at.least + k), light


@inlined
def keep(rows, k, at, t, least, ray):
    """Store where a vector of rays has come to, and whether there is more to look for."""
    _, _, end, _, light = ray
    store(rows, at.least + k, least)
    store(rows, at.place + k, t)
    store(rows, row.ASKED + k, where((t < end) & (least > -light[1]), ONE, ZERO * t))
