"""The rays of one pixel against a solid that has no kernels of its own: together, or one by one."""

from __future__ import annotations

import numpy as np

from ...jit import device, inlined
from ...meshes.kernels.ray_packet import RAYS
from ...simd.local import local_float64
from .distance_field import INF, ZERO, ray_in_own, through, trace


@device
def ray_of(rays, k):
    """Origin and direction of a ray, in single precision; rays: six rows of `RAYS` numbers."""
    return (
        np.float32(rays[k]), np.float32(rays[RAYS + k]), np.float32(rays[2 * RAYS + k]),
        np.float32(rays[3 * RAYS + k]), np.float32(rays[4 * RAYS + k]), np.float32(rays[5 * RAYS + k]),
    )  # fmt: skip


@device
def put_ray(rays, k, ray):
    """Write origin and direction of a ray."""
    rays[k], rays[RAYS + k], rays[2 * RAYS + k] = ray[0], ray[1], ray[2]
    rays[3 * RAYS + k], rays[4 * RAYS + k], rays[5 * RAYS + k] = ray[3], ray[4], ray[5]


@inlined
def trace_rays(distance, meets, p, m, rays, found):
    """Write to `found` what `distance_field.trace` returns for each of the `RAYS` rays, by `meets`; rays are lost."""
    starts = local_float64()
    for k in range(RAYS):
        ox, oy, oz, dx, dy, dz = ray_of(rays, k)
        t, end = through(p, m, ox, oy, oz, dx, dy, dz)
        starts[k] = t
        x, y, z = ox + t * dx, oy + t * dy, oz + t * dz
        misses = end < t or (t == ZERO and distance(p, m, x, y, z) < ZERO)
        found[k] = -1.0 if misses else np.inf
        put_ray(rays, k, ray_in_own(p, m, x, y, z, dx, dy, dz))
    meets(p, m, rays, found)
    for k in range(RAYS):
        found[k] = np.float32(starts[k]) + np.float32(found[k]) if found[k] >= 0.0 else INF


@inlined
def trace_each(distance, meet, p, m, rays, found):
    """The same by `distance_field.trace`."""
    for k in range(RAYS):
        ox, oy, oz, dx, dy, dz = ray_of(rays, k)
        found[k] = trace(distance, meet, p, m, ox, oy, oz, dx, dy, dz)
