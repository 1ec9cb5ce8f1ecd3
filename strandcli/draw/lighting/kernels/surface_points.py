"""Points of a solid: where they are, their normals and opacity, and the ambient light on and in their coat."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device
from ....jit.indices import FIRST, SECOND, THIRD
from ....simd import broadcast, lane_count, load, load3, pointer, sqrt, store, store3
from ....solids.kernels import built_in
from ....solids.kernels.built_in import device_if_built_in
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
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        right = (load(rows, surface.SX + k) - view[AXIS_X]) / focal
        up = (view[AXIS_Y] - load(rows, surface.SY + k)) / focal
        ox, oy, oz, dx, dy, dz = rays.ray(view, right, up)
        t = load(rows, surface.DISTANCE + k)
        far = ONE / sqrt(dx * dx + dy * dy + dz * dz)
        store3(rows, X + k, W, ox + t * dx, oy + t * dy, oz + t * dz)
        store3(rows, EX + k, W, -far * dx, -far * dy, -far * dz)
        if view[PERSPECTIVE] > ZERO:
            store(rows, surface.PIXEL + k, t / (focal * far))
        else:
            store(rows, surface.PIXEL + k, ONE / focal)


@device
def face(work, n, solids, which):
    """Store the unit normals; of a solid that has a look of its own its lifts and colours, too."""
    first = built_in.count(solids)
    if which < first:
        face_built_in(solids, work, n, which)
    else:
        appearance.face_custom(solids, work, n, which - first)


@device_if_built_in(lambda solids, work, n, which: None)
def face_built_in(solids, work, n, which):
    """`face` of a solid of the four shapes."""
    for k in range(n):
        x, y, z = vector_at(work, X, k)
        set_vector(work, surface.NX, k, rays.normal_built_in(solids, which, x, y, z))


@device
def light_around(work, n, surround, bounce, depth):
    """Set the radiance to that in ambient light, occluded by strands and solids. What occludes it is as light as the
    strands, ``bounce`` (3,); for a solid with subsurface scattering (depth > 0), whose own folds do, as the solid."""
    set_surroundings(work, n, surround, NORMALS, LIGHT)
    if surround.volume.shape[0] > 0:
        look_up_sky(work, n, surround, NORMALS)
        rows = pointer(work)
        for k in range(0, n, lane_count(rows)):
            share = load(rows, surface.MIRRORED + k)
            for c in range(3):
                light = load(rows, RADIANCE + c * W + k)
                tone = load(rows, surface.ALBEDO + c * W + k) if depth > ZERO else broadcast(rows, bounce[c])
                store(rows, RADIANCE + c * W + k, light * (share / max(ONE - tone * (ONE - share), TINY)))


NORMALS, MIRRORS, LIGHT, GLEAM = (np.int64(row) for row in (surface.NX, surface.MX, RADIANCE, surface.COAT))


@device
def set_surroundings(work, n, surround, directions, to):
    """Store `surroundings` of the unit directions of three rows."""
    ambient, sky = surround.ambient, surround.sky
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        x, y, z = load3(rows, directions + k, W)
        for c in range(3):
            if sky.shape[0] > 0:
                store(rows, to + c * W + k, around(sky, SURFACE, c, x, y, z) + ambient[c])
            else:
                store(rows, to + c * W + k, ambient[c])


@device
def look_up_sky(work, n, surround, directions):
    """Store the visible share of the sky about the unit directions of three rows, `MIRRORED`."""
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        share = occlusion.sky_visibilities(
            surround.volume, surround.box, load3(rows, X + k, W), load3(rows, directions + k, W)
        )
        store(rows, surface.MIRRORED + k, share)


@device
def fade(work, n, paint, which):
    """Store the opacity of a solid, which fades with the distance from a centre."""
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        store(rows, surface.THERE + k, ONE)
        if paint[which, FADE] > ZERO:
            x, y, z = load3(rows, X + k, W)
            x, y, z = x - paint[which, FADE_X], y - paint[which, FADE_Y], z - paint[which, FADE_Z]
            there = max(ONE - sqrt(x * x + y * y + z * z) / paint[which, FADE], ZERO)
            store(rows, surface.THERE + k, there * there * (np.float32(3.0) - np.float32(2.0) * there))


@device
def cover(work, n, surround, coats, which):
    """Store the ambient light that a coat mirrors, and the factor of the light under it."""
    rows = pointer(work)
    if coats[which, coat.COAT] <= ZERO:
        for k in range(0, n, lane_count(rows)):
            store(rows, surface.UNDER + k, ONE)
            store3(rows, surface.COAT + k, W, ZERO, ZERO, ZERO)
        return
    for k in range(0, n, lane_count(rows)):
        nx, ny, nz = load3(rows, surface.NX + k, W)
        wx, wy, wz = load3(rows, EX + k, W)
        facing = nx * wx + ny * wy + nz * wz
        store(rows, surface.UNDER + k, ONE - coat.mirrored(coats[which, coat.COAT], coats[which, coat.ROUGH], facing))
        store(rows, surface.MIRRORED + k, ONE)
        twice = facing + facing
        store3(rows, surface.MX + k, W, twice * nx - wx, twice * ny - wy, twice * nz - wz)
    if surround.volume.shape[0] > 0:
        look_up_sky(work, n, surround, MIRRORS)
    set_surroundings(work, n, surround, MIRRORS, GLEAM)
    for k in range(0, n, lane_count(rows)):
        nx, ny, nz = load3(rows, surface.NX + k, W)
        wx, wy, wz = load3(rows, EX + k, W)
        share = coat.mirrored(coats[which, coat.COAT], coats[which, coat.ROUGH], nx * wx + ny * wy + nz * wz)
        share = share * load(rows, surface.MIRRORED + k)
        r, g, b = load3(rows, surface.COAT + k, W)
        store3(rows, surface.COAT + k, W, r * share, g * share, b * share)


@device
def patch(work, n, coats, which):
    """Multiply the factor of the light under a coat by that of patches."""
    if coats[which, coat.MOTTLE] <= ZERO:
        return
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        nx, ny, nz = load3(rows, surface.NX + k, W)
        wx, wy, wz = load3(rows, EX + k, W)
        facing = nx * wx + ny * wy + nz * wz  # patches are wider where the surface is seen at a slant
        store(rows, surface.ACROSS + k, load(rows, surface.PIXEL + k) / max(facing, TINY))
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
