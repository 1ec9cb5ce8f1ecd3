"""Shading of solids.

Pixels that show the same solid are shaded in batches of W, like vertices in `shade_strands`: whatever needs no table is
a loop over a row, which LLVM vectorises.
"""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, inlined, parallel, prange
from ....jit.indices import places, task_at
from ....simd import broadcast, lane_count, load, pointer, store, store3
from ....solids.kernels import custom
from ....solids.kernels.outside import count
from ...common.kernels.batch import RADIANCE, vector_at
from ...common.kernels.keys import EMPTY, FIRST, LOW
from ...common.kernels.numbers import ZERO
from ...common.kernels.surface_batch import ALBEDO, COAT, LIFT, ROWS, THERE, UNDER
from ...solids.kernels import coat
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
        reflected = mirror.Rays(
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
            mirror_solids(n, solid, surround, strands, lights, shadows, solids, coating, reflected, coating.mirrors)
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
    if custom.has_look(solids) or depth > ZERO:
        for k in range(0, n, lane_count(pointer(work))):  # its own colour, and no lift
            store3(pointer(work), ALBEDO + k, W, paint[which, 0], paint[which, 1], paint[which, 2])
            store3(pointer(work), LIFT + k, W, ZERO, ZERO, ZERO)
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
    rows = pointer(work)
    for k in range(0, n, lane_count(rows)):
        for c in range(3):
            tone = broadcast(rows, coating.paint[which, c])
            if custom.has_look(solids):
                tone = load(rows, ALBEDO + c * W + k)
            under = load(rows, RADIANCE + c * W + k)
            if coating.coats.shape[0] == 0:
                store(rows, RADIANCE + c * W + k, under * tone)
            else:
                light = load(rows, UNDER + k) * under * tone + load(rows, COAT + c * W + k)
                store(rows, RADIANCE + c * W + k, light)


@device
def mirror_solids(n, which, surround, strands, lights, shadows, solids, coating, reflected, mirrors):
    """Add to the radiance of a batch the solids and strands that its coat mirrors; reflected: `mirror.Rays`; mirrors:
    None compiles nothing."""
    if mirrors is None:  # an argument, not a field: Numba then compiles nothing of the rest
        return
    coats, seen, rows = coating.coats, reflected.seen, reflected.rows
    if mirror.strength(coats, which) == ZERO:
        return
    mirror.follow(reflected, n, solids, which)
    bare = Coating(coating.paint, coating.bare, coating.bare, mirrors)
    for hit in range(mirror.FREE, count(solids)):
        m = mirror.gather(reflected, n, hit)
        if m > 0 and hit >= 0:
            batch(seen, m, hit, surround, strands, lights, shadows, solids, bare)
        for k in range(m):
            p = reflected.points[k]
            light = ZERO, ZERO, ZERO
            there = ZERO
            if hit >= 0:
                light = vector_at(seen, RADIANCE, k)
                there = seen[THERE + k]
            sky = surroundings(surround, vector_at(rows, mirror.DIRECTION, p))
            mirror.add(reflected, p, light, there, sky, surround, strands, lights.rows, coats, which)


SHADED = np.uint8(0)
"""In `Screen.hidden`: of pixels that are not left as they are."""
SIDE_BITS = np.int64(3)
SIDE = np.int64(8)
"""Side of a square of pixels that are shaded one after the other."""
WITHIN = np.arange(SIDE * SIDE)
DOWN = (WITHIN >> 1 & 1) + (WITHIN >> 2 & 2) + (WITHIN >> 3 & 4)
ACROSS = (WITHIN & 1) + (WITHIN >> 1 & 2) + (WITHIN >> 2 & 4)
"""Rows down and columns across from the first pixel of a square, in an order in which sixteen pixels one after the
other are a square of 4 × 4: they read the same texels."""


@device
def find_pixels(screen, p, end, width, found):
    """Write to found (places,) int64 the pixels to shade among the places p … end − 1, in their order: square by
    square (`DOWN`, `ACROSS`), or in their own where they have positions of their own. Return how many they are. Squares
    without any are passed over by loops without branches."""
    n = np.int64(0)
    for begin in range(p, end, SIDE * SIDE):
        if screen.spots.shape[0] > 0:
            for place in range(begin, min(begin + SIDE * SIDE, end)):
                at = screen.begin * width + place
                found[n] = at
                n += np.int64(is_wanted(screen, at))
            continue
        column, row = square_at(begin, screen, width)
        wide, tall = min(SIDE, np.int64(width) - column), min(SIDE, np.int64(screen.end) - row)
        first = row * width + column
        some = False
        for y in range(tall):
            for x in range(wide):
                some |= is_wanted(screen, first + y * width + x)
        for place in range(np.uint64(SIDE * SIDE if some else 0)):
            down, across = DOWN[place], ACROSS[place]
            inside = (across < wide) & (down < tall)
            at = first + (down * width + across if inside else np.int64(0))
            found[np.uint64(n)] = at
            n += np.int64(inside & is_wanted(screen, at))
    return n


@inlined
def is_wanted(screen, at):
    """Return whether pixel number `at` shows a solid and is to be shaded. Without branches."""
    key = screen.keys[np.uint64(at)]
    shown = (key != EMPTY) & ((key & LOW) >= FIRST)
    if screen.hidden.shape[0] > 0:
        shown &= screen.hidden[np.uint64(at)] == SHADED
    return shown


@inlined
def places_in(screen, width):
    """Return the number of places of `find_pixels`."""
    rows, columns = np.int64(screen.end - screen.begin), np.int64(width)
    if screen.spots.shape[0] > 0:
        return rows * columns
    return ((rows + SIDE - 1) >> SIDE_BITS) * ((columns + SIDE - 1) >> SIDE_BITS) * SIDE * SIDE


@inlined
def square_at(place, screen, width):
    """Return column and row of the first pixel of the square that a place is in."""
    across = (np.int64(width) + SIDE - 1) >> SIDE_BITS
    square = place >> (2 * SIDE_BITS)
    down = square // across
    return (square - down * across) * SIDE, screen.begin + down * SIDE
