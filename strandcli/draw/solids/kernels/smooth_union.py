"""The smooth union of spheres and capsules: one surface about all that blend.

Its distance is d = −k ln Σ e^(−dᵢ / k), with the distances dᵢ of the solids: never more than the least of them, and as
steep at the most, so that a ray may go on by it (Hart 1996, "Sphere Tracing"). k is the blending distance of the first
of them, spheres before capsules, as which all are drawn. Columns as packed by `strandcli.draw.solids.solids.packed`;
without that of the blending distance nothing blends. Shadows and contact are those of the solids themselves.
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
"""At the most. A ray that grazes a radius r takes π √(r / 2h) of them where it passes it at h: h is `NEAR` k or more,
so they are enough for r up to 500 k, and few rays take many."""
NEAR = np.float32(0.04)
"""Part of k within which a ray has met the surface."""
APART = np.float32(6.0)
"""Times k from which on a solid is not felt beside another: e^-6 of k."""
EVERY = np.uint64(0xFFFFFFFFFFFFFFFF)


@device
def blends(spheres, capsules, m):
    """Whether solid number m is one that blends."""
    if m < spheres.shape[0]:
        return spheres.shape[1] > SPHERE and spheres[m, SPHERE] > ZERO
    m -= spheres.shape[0]
    if m < capsules.shape[0]:
        return capsules.shape[1] > CAPSULE and capsules[m, CAPSULE] > ZERO
    return False


@device
def blend_distance(spheres, capsules):
    """k: the blending distance of the first solid that blends, 1 where none does."""
    for m in range(spheres.shape[0]):
        if spheres[m, SPHERE] > ZERO:
            return spheres[m, SPHERE]
    for m in range(capsules.shape[0]):
        if capsules[m, CAPSULE] > ZERO:
            return capsules[m, CAPSULE]
    return ONE


@function
def surface(spheres, capsules, felt, k, x, y, z):
    """The distance of a point from the surface, and the gradient there, not of unit length; of the solids whose bit is
    set in ``felt`` (the 65th shares that of the first, and so on)."""
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
        if away < least:  # weights are shares of the nearest's, which this one is now
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
    """Centre and radius of the ball about solid number m."""
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
    """Where a ray along d is in the middle of a ball, of this radius squared, whose centre is at c from its origin, and
    half the way through it, in units of |d|; that is negative where it misses the ball."""
    dd = dx * dx + dy * dy + dz * dz
    t = (cx * dx + cy * dy + cz * dz) / dd
    cx -= t * dx
    cy -= t * dy
    cz -= t * dz
    left = square - (cx * cx + cy * cy + cz * cz)
    return t, math.sqrt(left / dd) if left > ZERO else -ONE


@function
def meet(spheres, capsules, ox, oy, oz, dx, dy, dz):
    """Distance along the ray, in units of |d|, to the outside of the surface; inf where it is missed or begins
    inside. Only solids whose balls the ray passes are felt, and only between the first and the last of these."""
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
    """Unit outward normal at a point of the surface."""
    _, nx, ny, nz = surface(spheres, capsules, EVERY, blend_distance(spheres, capsules), x, y, z)
    size = ONE / math.sqrt(max(nx * nx + ny * ny + nz * nz, TINY))
    return nx * size, ny * size, nz * size
