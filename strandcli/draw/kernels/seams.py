"""Spheres and capsules that run into each other: one smooth surface about all that blend.

Its distance is d = −k ln Σ e^(−dᵢ / k), with the distances dᵢ of the solids: never more than the least of them, and as
steep at the most, so that a ray may go on by it (Hart 1996, "Sphere Tracing"). k is the way of blending of the first of
them, spheres before capsules, as which all are drawn. Columns as packed by `strandcli.draw.solids.packed`; without that
of the way of blending nothing blends. Shadows and contact are those of the solids themselves.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import function, inner
from .approximations import exp

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
TINY = np.float32(1e-20)
INF = np.float32(np.inf)
SPHERE, CAPSULE = 5, 9
"""Columns of the way of blending."""
STEPS = 64
NEAR = np.float32(2e-3)
"""Part of k within which a ray has met the surface."""
APART = np.float32(12.0)
"""Times k from which on a solid is not felt beside another."""


@inner
def blends(spheres, capsules, m):
    """Whether solid number m is one that blends."""
    if m < spheres.shape[0]:
        return spheres.shape[1] > SPHERE and spheres[m, SPHERE] > ZERO
    m -= spheres.shape[0]
    if m < capsules.shape[0]:
        return capsules.shape[1] > CAPSULE and capsules[m, CAPSULE] > ZERO
    return False


@inner
def way(spheres, capsules):
    """k."""
    for m in range(spheres.shape[0]):
        if spheres[m, SPHERE] > ZERO:
            return spheres[m, SPHERE]
    for m in range(capsules.shape[0]):
        if capsules[m, CAPSULE] > ZERO:
            return capsules[m, CAPSULE]
    return ONE


@inner
def from_axis(capsules, m, x, y, z):
    """From the nearest point of a capsule's axis to a point."""
    ox = x - capsules[m, 0]
    oy = y - capsules[m, 1]
    oz = z - capsules[m, 2]
    t = min(max((ox * capsules[m, 3] + oy * capsules[m, 4] + oz * capsules[m, 5]) * capsules[m, 7], ZERO), ONE)
    return ox - t * capsules[m, 3], oy - t * capsules[m, 4], oz - t * capsules[m, 5]


@function
def surface(spheres, capsules, k, x, y, z):
    """The distance of a point from the surface, and the gradient there, not of unit length."""
    least = INF
    total = ZERO
    nx = ZERO
    ny = ZERO
    nz = ZERO
    for m in range(spheres.shape[0] + capsules.shape[0]):
        own = m - spheres.shape[0]
        if own < 0:
            if spheres[m, SPHERE] <= ZERO:
                continue
            ox = x - spheres[m, 0]
            oy = y - spheres[m, 1]
            oz = z - spheres[m, 2]
            r = spheres[m, 3]
        else:
            if capsules[own, CAPSULE] <= ZERO:
                continue
            ox, oy, oz = from_axis(capsules, own, x, y, z)
            r = capsules[own, 6]
        size = math.sqrt(max(ox * ox + oy * oy + oz * oz, TINY))
        away = size - r
        if away > least + APART * k:
            continue
        weight = ONE
        if away < least:  # weights are shares of the nearest's, which this one is now
            fade = exp((away - least) / k) if least < INF else ZERO
            total *= fade
            nx *= fade
            ny *= fade
            nz *= fade
            least = away
        else:
            weight = exp((least - away) / k)
        total += weight
        weight /= size
        nx += weight * ox
        ny += weight * oy
        nz += weight * oz
    return least - k * np.float32(math.log(max(total, TINY))), nx, ny, nz


@function
def meet(spheres, capsules, ox, oy, oz, dx, dy, dz):
    """Distance along the ray, in units of |d|, to the outside of the surface; inf where it is missed or begins
    inside."""
    k = way(spheres, capsules)
    size = math.sqrt(dx * dx + dy * dy + dz * dz)
    t = ZERO
    last = INF
    for step in range(STEPS):
        away, nx, ny, nz = surface(spheres, capsules, k, ox + t * dx, oy + t * dy, oz + t * dz)
        if step == 0 and away < ZERO:
            return INF
        if away < NEAR * k:
            return t
        # past all of it: far away, and on the way out
        leaves = away > APART * k and away > last and nx * dx + ny * dy + nz * dz > ZERO
        if leaves and beyond(spheres, capsules, ox + t * dx, oy + t * dy, oz + t * dz, dx, dy, dz):
            return INF
        last = away
        t += away / size
    return t if last < TWO * TWO * TWO * NEAR * k else INF


@inner
def beyond(spheres, capsules, x, y, z, dx, dy, dz):
    """Whether all that blends lies behind a point of a ray."""
    for m in range(spheres.shape[0]):
        ahead = (spheres[m, 0] - x) * dx + (spheres[m, 1] - y) * dy + (spheres[m, 2] - z) * dz
        if spheres[m, SPHERE] > ZERO and ahead > ZERO:
            return False
    for m in range(capsules.shape[0]):
        ahead = (capsules[m, 0] - x) * dx + (capsules[m, 1] - y) * dy + (capsules[m, 2] - z) * dz
        other = ahead + capsules[m, 3] * dx + capsules[m, 4] * dy + capsules[m, 5] * dz
        if capsules[m, CAPSULE] > ZERO and max(ahead, other) > ZERO:
            return False
    return True


@function
def normal(spheres, capsules, x, y, z):
    """Unit outward normal at a point of the surface."""
    _, nx, ny, nz = surface(spheres, capsules, way(spheres, capsules), x, y, z)
    size = ONE / math.sqrt(max(nx * nx + ny * ny + nz * nz, TINY))
    return nx * size, ny * size, nz * size
