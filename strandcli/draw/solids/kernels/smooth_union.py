"""Smooth union of blended spheres and capsules: one implicit surface.

Its distance is d = −k ln Σ e^(−dᵢ / k), where dᵢ are the distances of the solids. It never exceeds the least of them
and its gradient is at most 1, so a ray may advance by it (Hart 1996, "Sphere Tracing"). k is the blending distance of
the first blended solid, spheres before capsules, under whose number the union is drawn. Columns are those of
`strandcli.draw.solids.solids.packed`; solids without the column of the blending distance do not blend. Shadows and
contact use the separate solids.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, function, inlined
from ....solids import COLUMNS
from ....solids.kernels import capsule, sphere
from ...common.kernels.approximations import exp, log

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
HALF = np.float32(0.5)
TINY = np.float32(1e-20)
INF = np.float32(np.inf)
SPHERE, CAPSULE = COLUMNS["sphere"], COLUMNS["capsule"]
"""Columns of the blending distance."""
STEPS = 256
"""Greatest number of steps. A ray that passes a surface of radius r at a height h takes π √(r / 2h) of them; h is at
least `NEAR` k, so this is enough for r up to 500 k. Few rays take many steps."""
NEAR = np.float32(0.04)
"""Distance from the surface, as a share of k, at which a ray counts as having met it."""
APART = np.float32(6.0)
"""Difference in distance, in units of k, beyond which a solid's contribution is ignored: at most e^-6 k."""
EVERY = np.uint64(0xFFFFFFFFFFFFFFFF)


@device
def blends(spheres, capsules, m):
    """Return whether solid number m is part of the smooth union."""
    if m < spheres.shape[0]:
        return spheres.shape[1] > SPHERE and spheres[m, SPHERE] > ZERO
    m -= spheres.shape[0]
    if m < capsules.shape[0]:
        return capsules.shape[1] > CAPSULE and capsules[m, CAPSULE] > ZERO
    return False


@device
def blend_distance(spheres, capsules):
    """Return k, the blending distance of the first blended solid, metres; 1 if there is none."""
    for m in range(spheres.shape[0]):
        if spheres[m, SPHERE] > ZERO:
            return spheres[m, SPHERE]
    for m in range(capsules.shape[0]):
        if capsules[m, CAPSULE] > ZERO:
            return capsules[m, CAPSULE]
    return ONE


@function
def surface(spheres, capsules, felt, k, x, y, z):
    """Return the distance of a point from the surface, metres, and its gradient, not normalised.

    felt: bit mask of the solids that count; solid m has bit m mod 64."""
    least = INF
    total = ZERO
    nx = ZERO
    ny = ZERO
    nz = ZERO
    for m in range(spheres.shape[0] + capsules.shape[0]):
        own = m - spheres.shape[0]
        if (felt >> np.uint64(m & 63)) & np.uint64(1) == np.uint64(0) or not blends(spheres, capsules, m):
            continue
        if own < 0:
            ox = x - spheres[m, sphere.X]
            oy = y - spheres[m, sphere.Y]
            oz = z - spheres[m, sphere.Z]
            r = spheres[m, sphere.RADIUS]
        else:
            ox, oy, oz = capsule.normal(capsules, own, x, y, z)
            r = capsules[own, capsule.RADIUS]
        size = math.sqrt(max(ox * ox + oy * oy + oz * oz, TINY))
        away = size - r
        if away > least + APART * k:
            continue
        weight = ONE
        if away < least:  # weights are relative to the nearest solid, which is now this one: rescale the sums
            fade = exp((away - least) / k) if least < away + APART * k else ZERO
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
    return least - k * log(max(total, TINY)), nx, ny, nz


@device
def ball_about(spheres, capsules, m):
    """Return centre and radius of a bounding ball of solid number m."""
    if m < spheres.shape[0]:
        return spheres[m, sphere.X], spheres[m, sphere.Y], spheres[m, sphere.Z], spheres[m, sphere.RADIUS]
    m -= spheres.shape[0]
    return (
        capsules[m, capsule.X] + HALF * capsules[m, capsule.AXIS_X],
        capsules[m, capsule.Y] + HALF * capsules[m, capsule.AXIS_Y],
        capsules[m, capsule.Z] + HALF * capsules[m, capsule.AXIS_Z],
        capsules[m, capsule.RADIUS] + HALF / math.sqrt(capsules[m, capsule.PER_SQUARE]),
    )


@inlined
def through(cx, cy, cz, square, dx, dy, dz):
    """Return the midpoint of a ray's chord in a ball and half the chord's length, in units of |d|; the latter is −1
    where the ray misses. c: centre relative to the ray's origin; square: radius², metres²; d: direction."""
    dd = dx * dx + dy * dy + dz * dz
    t = (cx * dx + cy * dy + cz * dz) / dd
    cx -= t * dx
    cy -= t * dy
    cz -= t * dz
    left = square - (cx * cx + cy * cy + cz * cz)
    return t, math.sqrt(left / dd) if left > ZERO else -ONE


@function
def meet(spheres, capsules, ox, oy, oz, dx, dy, dz):
    """Return the distance along a ray to the surface, in units of |d|; inf if it misses or begins inside. Only solids
    whose bounding balls the ray crosses count, and only the part of the ray within these balls is searched."""
    k = blend_distance(spheres, capsules)
    dd = dx * dx + dy * dy + dz * dz
    felt = np.uint64(0)
    begin = INF
    end = ZERO
    for m in range(spheres.shape[0] + capsules.shape[0]):
        if blends(spheres, capsules, m):
            cx, cy, cz, r = ball_about(spheres, capsules, m)
            r += APART * k
            middle, half = through(cx - ox, cy - oy, cz - oz, r * r, dx, dy, dz)
            if half >= ZERO and middle + half > ZERO:
                felt |= np.uint64(1) << np.uint64(m & 63)
                begin = min(begin, max(middle - half, ZERO))
                end = max(end, middle + half)
    if felt == np.uint64(0):
        return INF
    per = ONE / math.sqrt(dd)
    t = begin
    for step in range(STEPS):
        away, _, _, _ = surface(spheres, capsules, felt, k, ox + t * dx, oy + t * dy, oz + t * dz)
        if step == 0 and away < ZERO:
            return INF
        if away < NEAR * k:
            return t
        t += away * per
        if t > end:
            return INF
    return t if away < HALF * k else INF


@function
def normal(spheres, capsules, x, y, z):
    """Return the unit outward normal at a point of the surface."""
    _, nx, ny, nz = surface(spheres, capsules, EVERY, blend_distance(spheres, capsules), x, y, z)
    size = ONE / math.sqrt(max(nx * nx + ny * ny + nz * nz, TINY))
    return nx * size, ny * size, nz * size
