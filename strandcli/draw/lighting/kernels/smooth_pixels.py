"""Pixels of solids between those of a `lattice` that take all their light from there: row by row, because the lattice's
light is then summed once for the pixels on both sides of it."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, inlined, parallel, prange
from ....jit.balance import places, task_at
from ....solids.kernels import other
from ...common.kernels.batch import RADIANCE
from ...common.kernels.keys import FIRST, LOW, SHIFT
from ...common.kernels.numbers import HALF, ONE, ZERO
from ...common.kernels.surface_batch import BEFORE, COAT, DISTANCE, ROWS, SX, SY, UNDER
from ...common.kernels.view_columns import PERSPECTIVE
from ...solids.kernels import appearance, coat
from ...solids.kernels.surface_pixels import composite, distance
from .inputs import FADE
from .lattice import COATED, LIT, SMOOTH
from .shade_surfaces import colour
from .surface_points import face, fade, look, patch

ROWS_A_TASK = 8
SPAN = 4 * W
"""Columns that a batch extends over at the most."""
SUMS = SPAN // 2 + 2
"""Columns of the lattice that it takes light from at the most."""


@parallel
def shade_smooth(screen, lights, solids, coating, image):
    """Composite the visible solids over image (height, width, 3) at the pixels that `lattice.choose` has marked as
    `SMOOTH`. Arguments as in `shade_surfaces.surfaces`; each pixel is at its own position."""
    width = np.int64(image.shape[1])
    picture = image.reshape(-1)
    tasks = np.int64((np.int64(screen.end - screen.begin) + ROWS_A_TASK - 1) // ROWS_A_TASK)
    for turn in prange(places(tasks)):
        first = screen.begin + task_at(np.int64(turn), tasks) * ROWS_A_TASK
        work, which = np.empty(ROWS * W, np.float32), np.empty(W, np.int64)
        columns, sums = np.empty(width, np.int32), np.empty(6 * SUMS, np.float32)
        for y in range(first, min(first + ROWS_A_TASK, np.int64(screen.end))):
            end = list_columns(screen.hidden, y * width, columns)
            i = np.int64(0)
            while i < end:
                n, solid = count_alike(screen.keys, y * width, columns, i, end)
                fill(screen, y, width, (columns, i), n, solid, solids, coating, work, which)
                batch(work, n, solid, screen.camera, solids, coating)
                recall(work, n, y, (columns, i), lights, coating.coats, sums)
                colour(work, n, solid, solids, coating)
                composite(work, n, which, screen, width, picture)
                i += n


@device
def list_columns(hidden, first, columns):
    """Write the columns of the pixels of a row that are `SMOOTH`; return how many they are. Without branches."""
    n = np.uint64(0)
    for x in range(np.uint64(columns.shape[0])):
        columns[n] = x
        n += np.uint64(hidden[np.uint64(first) + x] == SMOOTH)
    return np.int64(n)


@device
def count_alike(keys, first, columns, i, end):
    """Return how many of the columns from number i on make a batch, all of one solid, and the solid's number."""
    x = np.int64(columns[i])
    own = keys[first + x] & LOW
    n = np.int64(1)
    while n < W and i + n < end and columns[i + n] < x + SPAN and keys[first + np.int64(columns[i + n])] & LOW == own:
        n += 1
    return n, np.int64(own - FIRST)


@device
def fill(screen, y, width, listed, n, which, solids, coating, work, at):
    """Store the places of n pixels of row y, listed: their columns from a number on, in a batch, and those on the
    surface of solid number `which` where it needs them; at (W,) int64 out: numbers of the pixels."""
    columns, i = listed
    for k in range(n):
        at[k] = y * width + np.int64(columns[i + k])
    if coating.paint[which, FADE] == ZERO and not is_patched(coating.coats, which):
        return
    flat = screen.camera[PERSPECTIVE] == ZERO
    for k in range(n):
        work[SX + k] = np.float32(columns[i + k]) + HALF
        work[SY + k] = np.float32(y) + HALF
        work[BEFORE + k] = -ONE
        work[DISTANCE + k] = ONE / np.uint32(LOW - (screen.keys[at[k]] >> SHIFT)).view(np.float32)
    if flat:  # the depth number is not one over the depth
        for k in range(n):
            work[DISTANCE + k] = distance(work[SX + k], work[SY + k], screen.camera, solids, which)
    look(work, n, screen.camera)


@inlined
def is_patched(coats, which):
    """Return whether solid number `which` has patches."""
    return coats.shape[0] > 0 and coats[which, coat.MOTTLE] > ZERO


@device
def batch(work, n, which, camera, solids, coating):
    """Store what is each pixel's own: opacity, patches and colour."""
    if other.has_look(solids):  # of another solid
        appearance.plain(work, n, coating.paint, which)
    fade(work, n, coating.paint, which)
    for k in range(n):
        work[UNDER + k] = ONE
    if is_patched(coating.coats, which):
        face(work, n, solids, which)
        patch(work, n, coating.coats, which)


@device
def recall(work, n, y, listed, lights, coats, sums):
    """Store `RADIANCE` and `COAT` from the lattice; sums (6 `SUMS`,): scratch; other arguments as in `fill`."""
    columns, i = listed
    up = np.uint64((y + np.int64(lights.down)) >> 1)
    low = np.uint64((y + np.int64(lights.down) + 1) >> 1)
    shift = np.int64(lights.right)
    begin = (np.int64(columns[i]) + shift) >> 1
    count = ((np.int64(columns[i + n - 1]) + shift + 1) >> 1) - begin + 1
    parts = 2 if coats.shape[0] > 0 else 1
    first = np.uint64(lights.rows.shape[0])
    for part in range(np.uint64(parts)):
        what = first + (LIT if part == np.uint64(0) else COATED)
        for c in range(np.uint64(3)):
            row = np.uint64(SUMS) * (np.uint64(3) * part + c)
            for a in range(np.uint64(count)):
                there = np.uint64(begin) + a
                sums[row + a] = HALF * (lights.known[up, there, what, c] + lights.known[low, there, what, c])
    for part in range(np.uint64(parts)):
        to = np.uint64(RADIANCE if part == np.uint64(0) else COAT)
        for c in range(np.uint64(3)):
            row = np.uint64(SUMS) * (np.uint64(3) * part + c)
            for k in range(np.uint64(n)):
                x = np.int64(columns[np.uint64(i) + k]) + shift
                left, right = row + np.uint64((x >> 1) - begin), row + np.uint64(((x + 1) >> 1) - begin)
                work[to + c * np.uint64(W) + k] = HALF * (sums[left] + sums[right])
