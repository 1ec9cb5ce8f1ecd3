"""Shading of solids.

Pixels that show the same solid are shaded in batches of W, like vertices in `shade_strands`: whatever needs no table is
a loop over a row, which LLVM vectorises.
"""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange
from ....jit.balance import places, task_at
from ....jit.indices import FIRST, SECOND, THIRD
from ....simd import lane_count, load, load3, pointer, store
from ....solids.kernels import other, sphere
from ...common.kernels.batch import EX, EY, EZ, RADIANCE, X, Y, Z
from ...common.kernels.surface_batch import (
    ACROSS,
    ALBEDO,
    COAT,
    DISTANCE,
    NX,
    NY,
    NZ,
    PIXEL,
    ROWS,
    SX,
    SY,
    THERE,
    UNDER,
)
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, FOCAL, PERSPECTIVE
from ...solids.kernels import appearance, blended, coat, rays
from ...solids.kernels.pixel_squares import find_pixels, places_in
from ...solids.kernels.surface_pixels import average, composite, fill_batch
from . import mirror, occlusion
from .inputs import FADE, FADE_X, FADE_Y, FADE_Z, READ, WRITTEN, Coating
from .light import SURFACE, around
from .mottle import mottle
from .reflection import deepest, gleam, reflect, reflect_from_below
from .surface_light import arrive, as_computed, note, recall

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-6)
INV_PI = np.float32(1 / math.pi)
PIXELS = 4096
"""Pixels a task."""


@parallel
def surfaces(screen, surround, strands, lights, shadows, solids, coating, image):
    """Composite the visible solids, with what is on and under their surface, over image (height, width, 3).

    screen, surround, strands, lights, coating: `Screen`, `Surround`, `StrandLight`, `Lights` and `Coating` of `inputs`;
    shadows: `ShadowArrays`; solids: `Solids`. The image contains the background. Blended solids may have edges in front
    of themselves, which z-buffer keys do not show; there a point on each side counts as much as 4×4 rays tell.
    """
    width = image.shape[1]
    picture = image.reshape(-1)
    last = places_in(screen, width)
    tasks = np.int64((last + PIXELS - 1) // PIXELS)
    for turn in prange(places(tasks)):
        first = task_at(np.int64(turn), tasks) * PIXELS
        found = np.empty(PIXELS, np.int64)
        end = find_pixels(screen, first, min(first + PIXELS, last), width, found)
        work = np.empty(ROWS * W, np.float32)
        which = np.empty(W, np.int64)
        way = mirror.Rays(
            work, np.empty(mirror.room(coating.mirrors, mirror.RAYS * W), np.float32), np.empty(W, np.int64),
            np.empty(W, np.int64), np.empty(mirror.room(coating.mirrors, ROWS * W), np.float32),
        )  # fmt: skip
        i = np.int64(0)
        while i < end:
            bare = lights.use == WRITTEN
            i, n, solid, fine = fill_batch(screen, found, i, end, width, solids, work, which, bare)
            if n == 0:
                continue
            look(work, n, screen.camera)
            if bare:
                keep(work, n, solid, strands, lights, shadows, solids, coating)
                continue
            batch(work, n, solid, surround, strands, lights, shadows, solids, coating)
            mirror_solids(n, solid, surround, strands, lights, shadows, solids, coating, way, coating.mirrors)
            if fine:
                n = average(work, n, which)
            composite(work, n, which, screen, width, picture)


@device
def keep(work, n, which, strands, lights, shadows, solids, coating):
    """Write the light that arrives at the first n points of a batch to the lattice; arguments as in `batch`."""
    depth = deepest(coating.coats, which)
    if other.has_look(solids) or depth > ZERO:
        appearance.plain(work, n, coating.paint, which)
    face(work, n, solids, which)
    for i in range(lights.rows.shape[0]):
        arrive(work, n, i, lights, shadows, solids, strands.loss, depth)
        note(work, n, i, lights)


@device
def surroundings(surround, x, y, z):
    """Return the radiance of a white surface of the unit normal (x, y, z) in unoccluded ambient light, as r, g, b."""
    ambient, sky = surround.ambient, surround.sky
    r, g, b = ambient[0], ambient[1], ambient[2]
    if sky.shape[0] > 0:
        r += around(sky, SURFACE, FIRST, x, y, z)
        g += around(sky, SURFACE, SECOND, x, y, z)
        b += around(sky, SURFACE, THIRD, x, y, z)
    return r, g, b


@device
def batch(work, n, which, surround, strands, lights, shadows, solids, coating):
    """Set the rows `RADIANCE` of the first n points of a batch, which are on solid number `which`."""
    paint, coats, rows = coating.paint, coating.coats, lights.rows
    depth = deepest(coats, which)
    if other.has_look(solids) or depth > ZERO:
        appearance.plain(work, n, paint, which)
    face(work, n, solids, which)
    light_around(work, n, surround, strands.bounce, depth)
    fade(work, n, paint, which)
    if coats.shape[0] > 0:
        cover(work, n, surround, coats, which)
    for i in range(rows.shape[0]):
        if lights.use == READ:
            recall(work, n, i, lights, depth)
        else:
            arrive(work, n, i, lights, shadows, solids, strands.loss, depth)
        if depth > ZERO:
            reflect_from_below(work, n, rows, i, coats, which)
        else:
            reflect(work, n, rows, i)
        if coats.shape[0] > 0:
            gleam(work, n, rows, i, coats, which)
    for c in range(3):
        tone = paint[which, c]
        for k in range(n):
            if other.has_look(solids):
                tone = work[ALBEDO + c * W + k]
            under = work[RADIANCE + c * W + k]
            if coats.shape[0] == 0:
                work[RADIANCE + c * W + k] = under * tone
            else:
                work[RADIANCE + c * W + k] = work[UNDER + k] * under * tone + work[COAT + c * W + k]


@device
def mirror_solids(n, which, surround, strands, lights, shadows, solids, coating, way, mirrors):
    """Add to the radiance of a batch the solids and strands that its coat mirrors; way: `mirror.Rays`; mirrors: None
    compiles nothing."""
    if mirrors is None:  # an argument, not a field: Numba then compiles nothing of the rest
        return
    coats, seen, ways = coating.coats, way.seen, way.ways
    if mirror.strength(coats, which) == ZERO:
        return
    mirror.follow(way, n, solids, which)
    bare = Coating(coating.paint, coating.bare, coating.bare, mirrors)
    computed = as_computed(lights)
    for hit in range(mirror.FREE, mirror.number_of(solids)):
        m = mirror.gather(way, n, hit)
        if m > 0 and hit >= 0:
            batch(seen, m, hit, surround, strands, computed, shadows, solids, bare)
        for k in range(m):
            p = way.points[k]
            light = ZERO, ZERO, ZERO
            there = ZERO
            if hit >= 0:
                light = seen[RADIANCE + k], seen[RADIANCE + W + k], seen[RADIANCE + 2 * W + k]
                there = seen[THERE + k]
            sky = surroundings(surround, ways[p], ways[W + p], ways[2 * W + p])
            mirror.add(way, p, light, there, sky, surround, strands, lights.rows, coats, which)


@device
def look(work, n, view):
    """Store points, unit directions to the eye and pixel widths, metres, from screen positions and depths."""
    focal = view[FOCAL]
    for k in range(n):
        right = (work[SX + k] - view[AXIS_X]) / focal
        up = (view[AXIS_Y] - work[SY + k]) / focal
        ox, oy, oz, dx, dy, dz = rays.ray(view, right, up)
        t = work[DISTANCE + k]
        far = ONE / math.sqrt(dx * dx + dy * dy + dz * dz)
        work[X + k] = ox + t * dx
        work[Y + k] = oy + t * dy
        work[Z + k] = oz + t * dz
        work[EX + k] = -far * dx
        work[EY + k] = -far * dy
        work[EZ + k] = -far * dz
        work[PIXEL + k] = t / (focal * far) if view[PERSPECTIVE] > ZERO else ONE / focal


@device
def face(work, n, solids, which):
    """Store the unit normals."""
    if which < solids.spheres.shape[0] and not blended.blends(solids, which):
        for k in range(n):
            x = work[X + k] - solids.spheres[which, sphere.X]
            y = work[Y + k] - solids.spheres[which, sphere.Y]
            z = work[Z + k] - solids.spheres[which, sphere.Z]
            size = ONE / math.sqrt(max(x * x + y * y + z * z, rays.TINY))
            work[NX + k] = x * size
            work[NY + k] = y * size
            work[NZ + k] = z * size
    elif appearance.looks(solids, which):
        appearance.face(work, n, solids, which)
    else:
        for k in range(n):
            x, y, z = rays.normal(solids, which, work[X + k], work[Y + k], work[Z + k])
            work[NX + k] = x
            work[NY + k] = y
            work[NZ + k] = z


@device
def light_around(work, n, surround, bounce, depth):
    """Set the radiance to that in ambient light, occluded by strands and solids. What occludes it is as light as the
    strands, ``bounce`` (3,); for a solid with subsurface scattering (depth > 0), whose own folds do, as the solid."""
    for k in range(n):
        r, g, b = surroundings(surround, work[NX + k], work[NY + k], work[NZ + k])
        work[RADIANCE + k] = r
        work[RADIANCE + W + k] = g
        work[RADIANCE + 2 * W + k] = b
    if surround.volume.shape[0] > 0:
        rows = pointer(work)
        for k in range(0, n, lane_count(rows)):
            share = occlusion.sky_visibilities(
                surround.volume, surround.box, load3(rows, X + k, W), load3(rows, NX + k, W)
            )
            for c in range(3):
                light = load(rows, RADIANCE + c * W + k)
                if depth > ZERO:
                    tone = load(rows, ALBEDO + c * W + k)
                    store(rows, RADIANCE + c * W + k, light * (share / max(ONE - tone * (ONE - share), TINY)))
                else:
                    store(rows, RADIANCE + c * W + k, light * (share / max(ONE - bounce[c] * (ONE - share), TINY)))


@device
def fade(work, n, paint, which):
    """Store the opacity of a solid, which fades with the distance from a centre."""
    for k in range(n):
        work[THERE + k] = ONE
    if paint[which, FADE] > ZERO:
        for k in range(n):
            x = work[X + k] - paint[which, FADE_X]
            y = work[Y + k] - paint[which, FADE_Y]
            z = work[Z + k] - paint[which, FADE_Z]
            there = max(ONE - math.sqrt(x * x + y * y + z * z) / paint[which, FADE], ZERO)
            work[THERE + k] = there * there * (np.float32(3.0) - np.float32(2.0) * there)


@device
def cover(work, n, surround, coats, which):
    """Store the ambient light that a coat mirrors, and the factor of the light under it, which includes patches."""
    for k in range(n):
        x, y, z = work[X + k], work[Y + k], work[Z + k]
        nx, ny, nz = work[NX + k], work[NY + k], work[NZ + k]
        wx, wy, wz = work[EX + k], work[EY + k], work[EZ + k]
        facing = nx * wx + ny * wy + nz * wz
        under = ONE
        r = g = b = ZERO
        if coats[which, coat.COAT] > ZERO:
            share = coat.mirrored(coats[which, coat.COAT], coats[which, coat.ROUGH], facing)
            under = ONE - share
            # mirror direction of the eye
            mx = (facing + facing) * nx - wx
            my = (facing + facing) * ny - wy
            mz = (facing + facing) * nz - wz
            r, g, b = surroundings(surround, mx, my, mz)
            if surround.volume.shape[0] > 0:
                share *= occlusion.sky_visibility(surround.volume, surround.box, x, y, z, mx, my, mz)
            r *= share
            g *= share
            b *= share
        work[ACROSS + k] = work[PIXEL + k] / max(facing, TINY)  # wider where the surface is seen at a slant
        work[UNDER + k] = under
        work[COAT + k] = r
        work[COAT + W + k] = g
        work[COAT + 2 * W + k] = b
    if coats[which, coat.MOTTLE] > ZERO:
        mottle(work, n, coats[which, coat.MOTTLE], coats[which, coat.GRAIN])
