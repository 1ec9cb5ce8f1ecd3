"""Points of a solid: where they are, their normals and opacity, and the ambient light on and in their coat."""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device
from ....jit.indices import FIRST, SECOND, THIRD
from ....simd import lane_count, load, load3, pointer, store
from ....solids.kernels import built_in, other, sphere
from ...common.kernels import surface_batch as surface
from ...common.kernels.batch import EX, RADIANCE, X, set_vector, vector_at
from ...common.kernels.numbers import HALF, INF, ONE, ZERO
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, FOCAL, PERSPECTIVE
from ...solids.kernels import appearance, coat, rays
from . import occlusion
from .inputs import FADE, FADE_X, FADE_Y, FADE_Z
from .light import SURFACE, around

TINY = np.float32(1e-6)


@device
def surroundings(surround, normal):
    """Return the radiance of a white surface of a unit normal in unoccluded ambient light, as r, g, b."""
    ambient, sky = surround.ambient, surround.sky
    x, y, z = normal
    r, g, b = ambient[0], ambient[1], ambient[2]
    if sky.shape[0] > 0:
        r += around(sky, SURFACE, FIRST, x, y, z)
        g += around(sky, SURFACE, SECOND, x, y, z)
        b += around(sky, SURFACE, THIRD, x, y, z)
    return r, g, b


@device
def look(work, n, view):
    """Store points, unit directions to the eye and pixel widths, metres, from screen positions and depths."""
    focal = view[FOCAL]
    for k in range(n):
        right = (work[surface.SX + k] - view[AXIS_X]) / focal
        up = (view[AXIS_Y] - work[surface.SY + k]) / focal
        ox, oy, oz, dx, dy, dz = rays.ray(view, right, up)
        t = work[surface.DISTANCE + k]
        far = ONE / math.sqrt(dx * dx + dy * dy + dz * dz)
        set_vector(work, X, k, (ox + t * dx, oy + t * dy, oz + t * dz))
        set_vector(work, EX, k, (-far * dx, -far * dy, -far * dz))
        work[surface.PIXEL + k] = t / (focal * far) if view[PERSPECTIVE] > ZERO else ONE / focal


@device
def face(work, n, solids, which):
    """Store the unit normals."""
    if which < solids.spheres.shape[0]:
        for k in range(n):
            x, y, z = vector_at(work, X, k)
            x -= solids.spheres[which, sphere.X]
            y -= solids.spheres[which, sphere.Y]
            z -= solids.spheres[which, sphere.Z]
            size = ONE / math.sqrt(max(x * x + y * y + z * z, rays.TINY))
            set_vector(work, surface.NX, k, (x * size, y * size, z * size))
    elif other.has_look(solids) and which >= built_in.count(solids):
        appearance.face(work, n, solids, which)
    elif 0 <= which - solids.spheres.shape[0] - solids.capsules.shape[0] < solids.planes.shape[0]:  # is a plane
        normal = rays.normal(solids, which, work[X], work[X + W], work[X + 2 * W])
        for k in range(n):
            set_vector(work, surface.NX, k, normal)
    else:
        for k in range(n):
            x, y, z = vector_at(work, X, k)
            set_vector(work, surface.NX, k, rays.normal(solids, which, x, y, z))


@device
def light_around(work, n, surround, bounce, depth):
    """Set the radiance to that in ambient light, occluded by strands and solids. What occludes it is as light as the
    strands, ``bounce`` (3,); for a solid with subsurface scattering (depth > 0), whose own folds do, as the solid."""
    for k in range(n):
        set_vector(work, RADIANCE, k, surroundings(surround, vector_at(work, surface.NX, k)))
    if surround.volume.shape[0] > 0:
        rows = pointer(work)
        for k in range(0, n, lane_count(rows)):
            share = occlusion.sky_visibilities(
                surround.volume, surround.box, load3(rows, X + k, W), load3(rows, surface.NX + k, W)
            )
            for c in range(3):
                light = load(rows, RADIANCE + c * W + k)
                if depth > ZERO:
                    tone = load(rows, surface.ALBEDO + c * W + k)
                    store(rows, RADIANCE + c * W + k, light * (share / max(ONE - tone * (ONE - share), TINY)))
                else:
                    store(rows, RADIANCE + c * W + k, light * (share / max(ONE - bounce[c] * (ONE - share), TINY)))


@device
def fade(work, n, paint, which):
    """Store the opacity of a solid, which fades with the distance from a centre."""
    for k in range(n):
        work[surface.THERE + k] = ONE
    if paint[which, FADE] > ZERO:
        for k in range(n):
            x, y, z = vector_at(work, X, k)
            x, y, z = x - paint[which, FADE_X], y - paint[which, FADE_Y], z - paint[which, FADE_Z]
            there = max(ONE - math.sqrt(x * x + y * y + z * z) / paint[which, FADE], ZERO)
            work[surface.THERE + k] = there * there * (np.float32(3.0) - np.float32(2.0) * there)


@device
def cover(work, n, surround, coats, which):
    """Store the ambient light that a coat mirrors, and the factor of the light under it."""
    if coats[which, coat.COAT] <= ZERO:
        for k in range(n):
            work[surface.UNDER + k] = ONE
            set_vector(work, surface.COAT, k, (ZERO, ZERO, ZERO))
        return
    for k in range(n):
        nx, ny, nz = vector_at(work, surface.NX, k)
        wx, wy, wz = vector_at(work, EX, k)
        facing = nx * wx + ny * wy + nz * wz
        share = coat.mirrored(coats[which, coat.COAT], coats[which, coat.ROUGH], facing)
        work[surface.UNDER + k] = ONE - share
        work[surface.MIRRORED + k] = share
        twice = facing + facing
        set_vector(work, surface.MX, k, (twice * nx - wx, twice * ny - wy, twice * nz - wz))
    if surround.volume.shape[0] > 0:
        rows = pointer(work)
        for k in range(0, n, lane_count(rows)):
            seen = occlusion.sky_visibilities(
                surround.volume, surround.box, load3(rows, X + k, W), load3(rows, surface.MX + k, W)
            )
            store(rows, surface.MIRRORED + k, load(rows, surface.MIRRORED + k) * seen)
    for k in range(n):
        r, g, b = surroundings(surround, vector_at(work, surface.MX, k))
        share = work[surface.MIRRORED + k]
        set_vector(work, surface.COAT, k, (r * share, g * share, b * share))


@device
def patch(work, n, coats, which):
    """Multiply the factor of the light under a coat by that of patches."""
    if coats[which, coat.MOTTLE] <= ZERO:
        return
    for k in range(n):
        nx, ny, nz = vector_at(work, surface.NX, k)
        wx, wy, wz = vector_at(work, EX, k)
        facing = nx * wx + ny * wy + nz * wz
        work[surface.ACROSS + k] = work[surface.PIXEL + k] / max(
            facing, TINY
        )  # wider where the surface is seen at a slant
    mottle(work, n, coats[which, coat.MOTTLE], coats[which, coat.GRAIN])


@device
def mottle(work, n, strength, grain):
    """Multiply the light under a coat by that of patches; grain: width of the largest, metres."""
    for k in range(n):
        work[surface.TONE + k] = ZERO
    size, weight = grain, HALF
    for octave in range(coat.OCTAVES):
        least = INF
        for k in range(n):
            least = min(least, work[surface.ACROSS + k])
        if least < size:  # finer octaves are not shown at all
            for k in range(n):
                x, y, z = vector_at(work, X, k)
                work[surface.TONE + k] = coat.add_octave(
                    work[surface.TONE + k], x, y, z, size, work[surface.ACROSS + k], weight, np.uint32(octave)
                )
        size *= HALF
        weight *= coat.FAINTER
    for k in range(n):
        work[surface.UNDER + k] *= ONE + strength * min(max(work[surface.TONE + k], -ONE), ONE)
