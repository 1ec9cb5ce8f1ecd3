"""Rays against all solids, `strandcli.solids.Solids`: where one meets them, the normal there, and what hides a light.

Solids are numbered through: spheres first, then capsules, planes, boxes, then those without kernels of their
own. Each shape's own part is in `strandcli.solids.kernels`.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, function
from ....solids.kernels import box, built_in, capsule, custom, plane, sphere
from ....solids.kernels.built_in import device_if_built_in
from ...common.kernels import view_columns as at
from ...common.kernels.numbers import INF, ONE, ZERO

TINY = np.float32(1e-20)


@function
def meet(solids, which, ox, oy, oz, dx, dy, dz):
    """Where a ray meets solid number `which`: its parameter, inf where it does not."""
    first = built_in.count(solids)  # number of the first without kernels of its own
    if which < first:
        return meet_built_in(solids, which, ox, oy, oz, dx, dy, dz)
    return custom.meet(solids, which - first, ox, oy, oz, dx, dy, dz)


@device_if_built_in(lambda solids, m, ox, oy, oz, dx, dy, dz: INF)
def meet_built_in(solids, m, ox, oy, oz, dx, dy, dz):
    """Return `meet` for a solid that has kernels of its own."""
    if m < solids.spheres.shape[0]:
        return sphere.meet(solids.spheres, m, ox, oy, oz, dx, dy, dz)
    m -= solids.spheres.shape[0]
    if m < solids.capsules.shape[0]:
        return capsule.meet(solids.capsules, m, ox, oy, oz, dx, dy, dz)
    m -= solids.capsules.shape[0]
    if m < solids.planes.shape[0]:
        return plane.meet(solids.planes, m, ox, oy, oz, dx, dy, dz)
    return box.meet(solids.boxes, m - solids.planes.shape[0], ox, oy, oz, dx, dy, dz)


@function
def normal(solids, which, x, y, z):
    """Unit outward normal of solid number `which` at a point of its surface."""
    first = built_in.count(solids)  # number of the first without kernels of its own
    if which < first:
        return normal_built_in(solids, which, x, y, z)
    return custom.normal(solids, which - first, x, y, z)


@device_if_built_in(lambda solids, m, x, y, z: (ZERO, ONE, ZERO))
def normal_built_in(solids, m, x, y, z):
    """Return `normal` for a solid that has kernels of its own."""
    if m < solids.spheres.shape[0]:
        nx, ny, nz = sphere.normal(solids.spheres, m, x, y, z)
    elif m < solids.spheres.shape[0] + solids.capsules.shape[0]:
        nx, ny, nz = capsule.normal(solids.capsules, m - solids.spheres.shape[0], x, y, z)
    elif m < solids.spheres.shape[0] + solids.capsules.shape[0] + solids.planes.shape[0]:
        nx, ny, nz = plane.normal(solids.planes, m - solids.spheres.shape[0] - solids.capsules.shape[0], x, y, z)
    else:
        m -= solids.spheres.shape[0] + solids.capsules.shape[0] + solids.planes.shape[0]
        nx, ny, nz = box.normal(solids.boxes, m, x, y, z)
    size = ONE / math.sqrt(max(nx * nx + ny * ny + nz * nz, TINY))
    return nx * size, ny * size, nz * size


@function
def visibility(solids, x, y, z, lx, ly, lz, reach, skin):
    """Return 1 if no solid is between a point and a light in the unit direction l, `reach` metres away; else 0.

    The ray begins `skin` metres from the point, so that a root, which may lie slightly below a surface, is not shaded
    by the solid that it grows from.
    """
    if visibility_past_built_in(solids, x, y, z, lx, ly, lz, reach, skin) == ZERO:
        return ZERO
    return custom.visibility(solids, x + skin * lx, y + skin * ly, z + skin * lz, lx, ly, lz, reach, skin)


@device_if_built_in(lambda solids, x, y, z, lx, ly, lz, reach, skin: ONE)
def visibility_past_built_in(solids, x, y, z, lx, ly, lz, reach, skin):
    """Return `visibility` past solids that have kernels of their own."""
    for s in range(solids.spheres.shape[0]):
        if sphere.visibility(solids.spheres, s, x, y, z, lx, ly, lz, reach, skin) == ZERO:
            return ZERO
    x, y, z = x + skin * lx, y + skin * ly, z + skin * lz
    for s in range(solids.capsules.shape[0]):
        if capsule.visibility(solids.capsules, s, x, y, z, lx, ly, lz, reach, skin) == ZERO:
            return ZERO
    for s in range(solids.planes.shape[0]):
        if skin < plane.meet(solids.planes, s, x, y, z, lx, ly, lz) < reach:
            return ZERO
    for s in range(solids.boxes.shape[0]):
        if skin < box.meet(solids.boxes, s, x, y, z, lx, ly, lz) < reach:
            return ZERO
    return ONE


@device
def ray(view, right, up):
    """Origin and direction of the ray through a point of the screen, (right, up) in metres at a depth of one metre; the
    direction's length is such that its parameter is the depth. No branch: view[PERSPECTIVE] is 1 for perspective,
    else 0."""
    ax = view[at.RIGHT_X] * right + view[at.UP_X] * up
    ay = view[at.RIGHT_Y] * right + view[at.UP_Y] * up
    az = view[at.RIGHT_Z] * right + view[at.UP_Z] * up
    spread = view[at.PERSPECTIVE]
    shift = ONE - spread
    return (
        view[at.EYE_X] + shift * ax,
        view[at.EYE_Y] + shift * ay,
        view[at.EYE_Z] + shift * az,
        view[at.FORWARD_X] + spread * ax,
        view[at.FORWARD_Y] + spread * ay,
        view[at.FORWARD_Z] + spread * az,
    )
