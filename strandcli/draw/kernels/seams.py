"""Normals that turn smoothly from one solid to the next, where both blend."""

from __future__ import annotations

import math

import numpy as np

from ...jit import function, inner

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-20)
BLEND = 7
"""Column of a solid's paint: metres over which it blends."""


@function
def smooth(spheres, capsules, paint, which, x, y, z, nx, ny, nz):
    """The normal n of solid number ``which`` at a point of its surface, turned toward those of spheres and capsules
    near by: the gradient of the smooth union by Quilez's quadratic minimum of distances a and b within k of each other,
    min(a, b) − (k − |a − b|)² / 4k. Halfway at the seam from either side, and none of it k metres from there.

    Only what blends takes part, paint (m, 8) as in `shade_surfaces.surfaces`; boxes and planes do not."""
    count = spheres.shape[0]
    for m in range(count + capsules.shape[0]):
        k = min(paint[which, BLEND], paint[m, BLEND])
        if m == which or k <= ZERO:
            continue
        if m < count:
            ox = x - spheres[m, 0]
            oy = y - spheres[m, 1]
            oz = z - spheres[m, 2]
            size = math.sqrt(max(ox * ox + oy * oy + oz * oz, TINY))
            away = size - spheres[m, 3]
        else:
            ox, oy, oz = from_axis(capsules, m - count, x, y, z)
            size = math.sqrt(max(ox * ox + oy * oy + oz * oz, TINY))
            away = size - capsules[m - count, 6]
        if away < k:
            turn = HALF * (ONE - max(away, ZERO) / k)
            per = turn / size
            nx += per * ox - turn * nx
            ny += per * oy - turn * ny
            nz += per * oz - turn * nz
    size = ONE / math.sqrt(max(nx * nx + ny * ny + nz * nz, TINY))
    return nx * size, ny * size, nz * size


@inner
def from_axis(capsules, m, x, y, z):
    """From the nearest point of a capsule's axis to a point."""
    ox = x - capsules[m, 0]
    oy = y - capsules[m, 1]
    oz = z - capsules[m, 2]
    t = min(max((ox * capsules[m, 3] + oy * capsules[m, 4] + oz * capsules[m, 5]) * capsules[m, 7], ZERO), ONE)
    return ox - t * capsules[m, 3], oy - t * capsules[m, 4], oz - t * capsules[m, 5]
