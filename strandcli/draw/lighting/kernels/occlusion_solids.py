"""What solids hide of the sky from the cells of a grid, direction by direction."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import W
from ....jit import device
from ....solids.kernels import custom
from ....solids.kernels.outside import outside
from ...common.kernels import batch
from ...common.kernels.batch import LEAST, RADIUS
from ...common.kernels.numbers import ONE, ZERO
from ...shadows.kernels import penumbra
from ...shadows.kernels.solid_shadows import by_distances
from ...solids.kernels import rays
from .occlusion import DENSITY, MIDDLE_X, MIDDLE_Y, MIDDLE_Z

DARK = np.uint8(0)
FAR = np.float32(1e30)


class Listed(NamedTuple):
    """Memory of `hide`."""

    work: NDArray[np.float32]
    """(`batch.ROWS` W,) rays past custom solids, a batch."""
    places: NDArray[np.int64]
    """(W,) their places in `every`."""
    every: NDArray[np.uint8]
    """(K V,) what `hide` changes."""
    near: NDArray[np.float32]
    """(cells of a slab, 4) cells near strands or surfaces: a point, and the number within the slab."""


@device
def hide(cells, counts, sides, box, directions, listed, solids, i):
    """Set what `occlusion_sweep.sweep` has left to 0 where a solid hides the sky from a cell of slab i; arguments as
    there; listed: `Listed`.

    For a cell whose centre is inside of a solid, the nearest point of the surface counts. Solids are tested only for
    cells near strands or surfaces, since only these are looked up. Rays past custom solids are listed, and go
    on together (`by_distances`): as soft shadows do, of a light without a size. That takes a tenth of the time of rays
    that meet triangles, and is as exact as light that varies from cell to cell needs.
    """
    wide = math.sqrt(sides[0] * sides[0] + sides[1] * sides[1] + sides[2] * sides[2])
    skin = np.float32(1e-3) * wide
    places = listed.near
    total = counts[0] * counts[1] * counts[2]
    found = np.int64(0)
    for j in range(counts[1]):
        for k in range(counts[2]):
            cell = (i * counts[1] + j) * counts[2] + k
            x = box[MIDDLE_X] + np.float32(i) * sides[0]
            y = box[MIDDLE_Y] + np.float32(j) * sides[1]
            z = box[MIDDLE_Z] + np.float32(k) * sides[2]
            ox, oy, oz = outside(x, y, z, wide, solids)
            if (ox == x) & (oy == y) & (oz == z) and not occupied(cells, counts, i, j, k):
                continue
            x, y, z = outside(x, y, z, skin + skin, solids)
            for d in range(directions.shape[0]):
                at = d * total + cell
                if listed.every[at] == DARK:
                    continue
                lx, ly, lz = directions[d, 0], directions[d, 1], directions[d, 2]
                if rays.visibility_past_built_in(solids, x, y, z, lx, ly, lz, FAR, skin) == ZERO:
                    listed.every[at] = DARK
            places[found, 0], places[found, 1], places[found, 2] = x, y, z
            places[found, 3] = np.float32(cell - i * counts[1] * counts[2])
            found += 1
    list_rays(solids, directions, listed, found, i * counts[1] * counts[2], total, skin)


@custom.by_form(lambda solids, directions, listed, found, slab, total, skin: None)
def list_rays(form):
    """`list_all` where there are custom solids."""
    return list_all


def list_all(solids, directions, listed, found, slab, total, skin):
    """Run `past_distances` for the first cells in `Listed.near`, so many as were found, direction by direction: rays of
    one direction that begin side by side take about as many steps.

    slab: number of its first cell; total: of all cells; other arguments as in `hide`.
    """
    work, near = listed.work, listed.near
    count = np.int64(0)
    for d in range(directions.shape[0]):
        for c in range(found):
            place = d * total + slab + np.int64(near[c, 3])
            if listed.every[place] == DARK:
                continue
            listed.places[count] = place
            batch.set_vector(work, batch.X, count, (near[c, 0], near[c, 1], near[c, 2]))
            batch.set_vector(work, batch.LX, count, (directions[d, 0], directions[d, 1], directions[d, 2]))
            count += 1
            if count == W:
                past_distances(listed, count, solids, skin)
                count = np.int64(0)
    past_distances(listed, count, solids, skin)


@device
def past_distances(listed, count, solids, skin):
    """Set what is left of listed rays to 0 where custom solids hide the light."""
    work = listed.work
    for j in range(count):
        work[batch.REACH + j] = FAR
        work[RADIUS + j] = penumbra.SHARP
        work[LEAST + j] = ONE
    by_distances(work, count, solids, ZERO, skin)
    for j in range(count):
        if not work[LEAST + j] > ZERO:
            listed.every[listed.places[j]] = DARK


@device
def occupied(cells, counts, i, j, k):
    """Return whether a cell or one of its neighbours contains strands."""
    for a in range(max(i - 1, 0), min(i + 2, counts[0])):
        for b in range(max(j - 1, 0), min(j + 2, counts[1])):
            for c in range(max(k - 1, 0), min(k + 2, counts[2])):
                if cells[(a * counts[1] + b) * counts[2] + c, DENSITY] > ZERO:
                    return True
    return False
