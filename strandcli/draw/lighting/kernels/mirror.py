"""What a polished coat mirrors: solids, shaded as those that are seen, and strands.

One ray in the mirror direction is followed from each point to the nearest other solid. Strands are known from the grid
of ambient occlusion: where hardly any sky is left along the ray, there are strands in its way, and they mirror as a
matt surface of their colour that faces the point. The rougher a coat, the less of this it shows, and at a roughness of
`DULL` it mirrors ambient light alone. What a coat mirrors has no coat.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import W
from ....jit import device
from ....simd import lane_count, load, pointer, reduce_max
from ....solids.kernels.outside import count
from ...common.kernels.batch import EX, RADIANCE, X, set_vector, vector_at
from ...common.kernels.light_columns import POWER_R
from ...common.kernels.numbers import HALF, INF, INV_PI, ONE, STEPS, THREE, TWO, ZERO
from ...common.kernels.surface_batch import BEFORE, NX, PIXEL
from ...solids.kernels import coat, rays
from . import occlusion
from .light import toward
from .occlusion import COUNT_X, PER_METRE_X

DULL = np.float32(0.4)
"""Roughness from which on a coat mirrors ambient light alone."""
SHARP = np.float32(0.2)
"""Roughness up to which a coat mirrors solids and strands in full."""
TESTED = 16
"""Places along a ray at which strands are looked for: whole vectors."""
OPEN, SHUT = np.float32(0.42), np.float32(0.2)
"""Share of the whole sky that is left where there are no strands, and where a ray does not get through."""
FREE = np.int64(-1)
"""Stands for a ray that meets no solid."""
DIRECTION, FAR = 0, 3 * W
"""Rows of a batch's rays: unit direction, three rows, and metres to the nearest other solid."""
RAYS = 4


@device
def strength(coats, which):
    """Return how much of solids and strands the coat of solid number `which` shows, 0 to 1."""
    if coats.shape[0] == 0 or coats[which, coat.COAT] <= ZERO:
        return ZERO
    return min(max((DULL - coats[which, coat.ROUGH]) / (DULL - SHARP), ZERO), ONE)


class Rays(NamedTuple):
    """The mirror rays of a batch."""

    work: NDArray[np.float32]
    """The batch."""
    rows: NDArray[np.float32]
    """(RAYS W,)"""
    hits: NDArray[np.int64]
    """(W,) number of the solid that each ray meets, or `FREE`."""
    points: NDArray[np.int64]
    """(W,) the rays whose ends are in `seen`."""
    seen: NDArray[np.float32]
    """A batch of the places that rays meet."""


@device
def room(mirrors, count):
    """Return `count`, or 0 where `mirrors` is None."""
    if mirrors is None:
        return np.int64(0)
    return np.int64(count)


@device
def follow(reflected, n, solids, which):
    """Store the mirror rays, `Rays`, of the first n points of a batch of solid number `which`, and what each meets."""
    work, rows = reflected.work, reflected.rows
    for k in range(n):
        nx, ny, nz = vector_at(work, NX, k)
        ex, ey, ez = vector_at(work, EX, k)
        facing = nx * ex + ny * ey + nz * ez
        mx, my, mz = TWO * facing * nx - ex, TWO * facing * ny - ey, TWO * facing * nz - ez
        x, y, z = vector_at(work, X, k)
        near = INF
        hit = FREE
        for j in range(count(solids)):
            if j == which:
                continue
            t = rays.meet(solids, j, x, y, z, mx, my, mz)
            if ZERO < t < near:
                near = t
                hit = np.int64(j)
        set_vector(rows, DIRECTION, k, (mx, my, mz))
        rows[FAR + k] = near
        reflected.hits[k] = hit


@device
def gather(reflected, n, hit):
    """Fill the batch `Rays.seen` with the points at which rays meet solid number `hit`; return how many."""
    work, rows, other = reflected.work, reflected.rows, reflected.seen
    m = np.int64(0)
    for k in range(n):
        if reflected.hits[k] != hit:
            continue
        far = rows[FAR + k]
        x, y, z = vector_at(work, X, k)
        mx, my, mz = vector_at(rows, DIRECTION, k)
        set_vector(other, X, m, (x + far * mx, y + far * my, z + far * mz))
        set_vector(other, EX, m, (-mx, -my, -mz))
        other[PIXEL + m] = TWO * work[PIXEL + k]
        other[BEFORE + m] = -ONE
        reflected.points[m] = k
        m += np.int64(1)
    return m


@device
def add(reflected, k, seen, there, sky, surround, strands, lights, coats, which):
    """Add to point k of a batch what its coat mirrors instead of ambient light: a radiance `seen` (r, g, b), of which
    the share `there` covers the radiance `sky` (r, g, b), behind strands. strands: `StrandLight`; lights: the rows of
    `Lights`."""
    work, rows = reflected.work, reflected.rows
    ray, place = vector_at(rows, DIRECTION, k), vector_at(work, X, k)
    nx, ny, nz = vector_at(work, NX, k)
    ex, ey, ez = vector_at(work, EX, k)
    facing = nx * ex + ny * ey + nz * ez
    share = strength(coats, which) * coat.mirrored(coats[which, coat.COAT], coats[which, coat.ROUGH], facing)
    visible = ONE
    covered = ZERO
    if surround.volume.shape[0] > 0:
        visible = occlusion.sky_visibility(
            surround.volume, surround.box, place[0], place[1], place[2], ray[0], ray[1], ray[2]
        )
        covered = strands_along(surround, place, ray, rows[FAR + k])
    for c in range(3):
        arrives = HALF * sky[c]
        for i in range(lights.shape[0]):
            lx, ly, lz, _, falloff = toward(lights, i, place)
            away = -(ray[0] * lx + ray[1] * ly + ray[2] * lz)
            arrives += INV_PI * max(away, ZERO) * falloff * lights[i, POWER_R + c]
        found = there * seen[c] + (ONE - there) * sky[c]
        found += covered * (strands.bounce[c] * arrives - found)
        work[RADIANCE + c * W + k] += share * (found - visible * sky[c])


@device
def strands_along(surround, place, ray, far):
    """Return how much of what is behind them strands hide along a ray of `far` metres: by the least share of the sky
    that is left on it, the solids' part of which is there at its ends."""
    box = surround.box
    long = ZERO
    for axis in range(3):
        side = box[COUNT_X + axis] / box[PER_METRE_X + axis]
        long += side * side
    long = min(math.sqrt(long), far)
    least = ONE
    steps = pointer(STEPS)
    for step in range(0, TESTED, lane_count(steps)):
        t = long * (load(steps, step) + HALF) / np.float32(TESTED)
        sky = occlusion.sky_visibilities(
            surround.volume, box, (place[0] + t * ray[0], place[1] + t * ray[1], place[2] + t * ray[2]), None
        )
        least = min(least, -reduce_max(-sky))
    hidden = min(max((OPEN - least) / (OPEN - SHUT), ZERO), ONE)
    return hidden * hidden * (THREE - TWO * hidden)
