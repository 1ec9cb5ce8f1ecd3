"""Shading of solids.

Pixels that show the same solid are shaded in batches of W, like vertices in `shade_strands`: whatever needs no table is
a loop over a row, which LLVM vectorises.
"""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange
from ....jit.balance import places, task_at
from ....solids.kernels import other
from ...common.kernels.batch import RADIANCE, vector_at
from ...common.kernels.numbers import ZERO
from ...common.kernels.surface_batch import ALBEDO, COAT, LIFT, ROWS, THERE, UNDER
from ...solids.kernels import coat
from ...solids.kernels.pixel_squares import find_pixels, places_in
from ...solids.kernels.surface_pixels import average, composite, fill_batch
from . import mirror
from .inputs import Coating
from .reflection import arrive, gleam, reflect, reflect_from_below
from .surface_points import cover, face, fade, light_around, look, patch, surroundings

PIXELS = 4096
"""Pixels a task."""


@parallel
def surfaces(screen, surround, strands, lights, shadows, solids, coating, image):
    """Composite the visible solids, with what is on and under their surface, over image (height, width, 3).

    screen, surround, strands, lights, coating: `Screen`, `Surround`, `StrandLight`, `Lights` and `Coating` of `inputs`;
    shadows: `ShadowArrays`; solids: `Solids`. The image contains the background. Meshes may have edges in front of
    themselves, which z-buffer keys do not show; there a point on each side counts as much as 4×4 rays tell.
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
            i, n, solid, fine = fill_batch(screen, found, i, end, width, solids, work, which)
            if n == 0:
                continue
            look(work, n, screen.camera)
            batch(work, n, solid, surround, strands, lights, shadows, solids, coating)
            mirror_solids(n, solid, surround, strands, lights, shadows, solids, coating, way, coating.mirrors)
            if fine:
                n = average(work, n, which)
            composite(work, n, which, screen, width, picture)


@device
def batch(work, n, which, surround, strands, lights, shadows, solids, coating):
    """Set the rows `RADIANCE` of the first n points of a batch, which are on solid number `which`."""
    paint, coats, rows = coating.paint, coating.coats, lights.rows
    depth = ZERO  # greatest width of subsurface scattering
    for c in range(3 if coats.shape[0] > 0 else 0):
        depth = max(depth, coats[which, coat.SUBSURFACE + c])
    if other.has_look(solids) or depth > ZERO:
        for c in range(3):  # its own colour, and no lift
            for k in range(n):
                work[ALBEDO + c * W + k] = paint[which, c]
                work[LIFT + c * W + k] = ZERO
    face(work, n, solids, which)
    light_around(work, n, surround, strands.bounce, depth)
    fade(work, n, paint, which)
    if coats.shape[0] > 0:
        cover(work, n, surround, coats, which)
        patch(work, n, coats, which)
    for i in range(rows.shape[0]):
        arrive(work, n, i, lights, shadows, solids, strands.loss, depth)
        if depth > ZERO:
            reflect_from_below(work, n, rows, i, coats, which)
        else:
            reflect(work, n, rows, i)
        if coats.shape[0] > 0:
            gleam(work, n, rows, i, coats, which)
    colour(work, n, which, solids, coating)


@device
def colour(work, n, which, solids, coating):
    """Multiply the rows `RADIANCE`, of a white surface, by its colour and what passes its coat, and add the coat's."""
    for c in range(3):
        tone = coating.paint[which, c]
        for k in range(n):
            if other.has_look(solids):
                tone = work[ALBEDO + c * W + k]
            under = work[RADIANCE + c * W + k]
            if coating.coats.shape[0] == 0:
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
    for hit in range(mirror.FREE, mirror.number_of(solids)):
        m = mirror.gather(way, n, hit)
        if m > 0 and hit >= 0:
            batch(seen, m, hit, surround, strands, lights, shadows, solids, bare)
        for k in range(m):
            p = way.points[k]
            light = ZERO, ZERO, ZERO
            there = ZERO
            if hit >= 0:
                light = vector_at(seen, RADIANCE, k)
                there = seen[THERE + k]
            sky = surroundings(surround, vector_at(ways, mirror.WAY, p))
            mirror.add(way, p, light, there, sky, surround, strands, lights.rows, coats, which)
