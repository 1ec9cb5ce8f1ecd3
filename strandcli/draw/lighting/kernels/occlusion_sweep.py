"""Ambient occlusion on a grid: light is swept through the cells from many directions.

A cell stores ρ = Σ width · length / volume of its strands, and M, the same sum over t tᵀ of their unit directions t.
For light along ω their extinction is σ = √(ρ² − ρ ωᵀM ω) (Heitz et al. 2015, "The SGGX Microflake Distribution"):
exact for parallel strands, 4 % too high for isotropic ones. The transmitted light is computed slab by slab against ω,
interpolated between the cells of the previous slab (short characteristics, Kunasz & Auer 1988); this diffuses it
sideways by about a cell.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import W
from ....jit import device, parallel, prange
from ....simd import broadcast, lane_count, load, load3, pointer, store, where
from ....solids.kernels import capsule, other, sphere
from ....solids.kernels.built_in import device_if_built_in
from ....solids.kernels.outside import count as count_solids
from ....solids.kernels.outside import outside
from ...common.kernels.approximations import exp
from ...shadows.kernels import penumbra
from ...solids.kernels import rays
from .occlusion_columns import (
    DENSITY,
    MEAN,
    MIDDLE_X,
    MIDDLE_Y,
    MIDDLE_Z,
    SLOPE_X,
    SLOPE_Y,
    SLOPE_Z,
    XX,
    XY,
    XZ,
    YY,
    YZ,
    ZZ,
)

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
NEXT = np.uint64(1)
THREE = np.float32(3.0)
LEVELS = np.float32(255.0)
FAR = np.float32(1e30)
LX, LY, LZ, LIGHT = (i * W for i in range(4))
ROWS = 4
"""Rows of numbers, one a direction: unit vector to the light, and transmitted light."""


class Grid(NamedTuple):
    """Size of the grid."""

    counts: NDArray[np.int64]
    """(3,) cells along each axis."""
    sides: NDArray[np.float32]
    """(3,) sides of a cell, metres."""


class Planes(NamedTuple):
    """Light and extinction in two slabs, padded by one cell on each side; float32."""

    before: NDArray[np.float32]
    """Transmitted light in the previous slab, 0 to 1."""
    after: NDArray[np.float32]
    """Transmitted light in this slab."""
    thick: NDArray[np.float32]
    """Extinction in the previous slab, 1/m."""
    thicker: NDArray[np.float32]
    """Extinction in this slab."""


@parallel
def sweep(cells, counts, sides, ways, left):
    """Write the transmittance of strands toward each direction to left (K, V) uint8, 255 for 1, at the cells' centres.

    cells (V, CHANNELS), 1/m; counts (3,) int64; sides (3,): sides of a cell, metres; ways (K, 3): unit vectors toward
    the light.
    """
    for way in prange(ways.shape[0]):
        d = np.int64(way)
        axis = np.int64(0)  # with a literal, Numba would compile the functions below twice
        for k in range(1, 3):
            if abs(ways[d, k]) * sides[axis] > abs(ways[d, axis]) * sides[k]:
                axis = k
        one = 1 if axis == 0 else 0
        two = 1 if axis == 2 else 2
        size = (counts[one] + 2) * (counts[two] + 2)
        planes = Planes(
            np.ones(size, np.float32), np.ones(size, np.float32), np.zeros(size, np.float32), np.zeros(size, np.float32)
        )
        sweep_direction(cells, Grid(counts, sides), ways, d, axis, one, two, planes, left)


@device
def sweep_direction(cells, grid, ways, d, axis, one, two, planes, left):
    """Run `sweep` for direction d, slab by slab along `axis`, on which it crosses most cells; one, two: other axes."""
    counts, sides = grid.counts, grid.sides
    before, after, thick, thicker = planes.before, planes.after, planes.thick, planes.thicker
    stride_z = np.int64(1)
    stride_y = counts[2]
    stride_x = counts[1] * counts[2]
    down = stride_x if axis == 0 else (stride_y if axis == 1 else stride_z)
    along = stride_x if one == 0 else stride_y
    beside = stride_y if two == 1 else stride_z
    x = ways[d, 0]
    y = ways[d, 1]
    z = ways[d, 2]
    steep = abs(ways[d, axis])
    half = HALF * sides[axis] / steep
    ratio = sides[axis] / steep
    f = ways[d, one] / sides[one] * ratio
    g = ways[d, two] / sides[two] * ratio
    low_f = np.int64(min(np.floor(f), ZERO))
    low_g = np.int64(min(np.floor(g), ZERO))
    f -= np.float32(low_f)
    g -= np.float32(low_g)
    row = np.uint64(counts[two] + 2)  # as places in planes, which cannot be negative: these loops are vectors
    for m in range(counts[axis]):
        slab = (counts[axis] - 1 - m if ways[d, axis] > ZERO else m) * down
        for p in range(counts[one]):
            base = slab + p * along
            own = np.uint64(p + 1) * row + NEXT
            up = np.uint64(p + 1 + low_f) * row + np.uint64(1 + low_g)
            for q in range(np.uint64(counts[two])):
                cell = np.uint64(base) + q * np.uint64(beside)
                r = cells[cell, DENSITY]
                inside = x * x * cells[cell, XX] + y * y * cells[cell, YY] + z * z * cells[cell, ZZ]
                inside += (ONE + ONE) * (x * y * cells[cell, XY] + x * z * cells[cell, XZ] + y * z * cells[cell, YZ])
                thicker[own + q] = math.sqrt(max(r * (r - inside), ZERO))
            for q in range(np.uint64(counts[two])):
                came = mixed(before, up + q, row, f, g)
                met = half * (thicker[own + q] + mixed(thick, up + q, row, f, g))
                after[own + q] = came * exp(-met)
            for q in range(np.uint64(counts[two])):
                left[d, np.uint64(base) + q * np.uint64(beside)] = np.uint8(after[own + q] * LEVELS + HALF)
        before, after = after, before
        thick, thicker = thicker, thick


@device
def mixed(plane, at, row, f, g):
    """Interpolate bilinearly in a plane; at: index of the upper left cell; row: cells a row."""
    upper = plane[at] + g * (plane[at + NEXT] - plane[at])
    lower = plane[at + row] + g * (plane[at + row + NEXT] - plane[at + row])
    return upper + f * (lower - upper)


@parallel
def combine(cells, counts, sides, box, ways, left, solids, volume):
    """Write the linear fit V(ω) = v₀ + v · ω of each cell's visibility past strands and solids to volume (V, 4): v₀ is
    the mean over directions, v three times the mean of visibility times direction.

    Arguments as in `sweep`; solids: packed. For a cell whose centre is inside of a solid, the nearest point of the
    surface counts. Solids are tested only for cells near strands or surfaces, since no others are looked up.
    """
    wide = math.sqrt(sides[0] * sides[0] + sides[1] * sides[1] + sides[2] * sides[2])
    skin = np.float32(1e-3) * wide
    per = ONE / (LEVELS * np.float32(ways.shape[0]))
    solid = count_solids(solids) > 0
    for slab in prange(counts[0]):
        i = np.int64(slab)
        work = np.zeros(ROWS * W, np.float32)
        for j in range(counts[1]):
            for k in range(counts[2]):
                cell = (i * counts[1] + j) * counts[2] + k
                x = box[MIDDLE_X] + np.float32(i) * sides[0]
                y = box[MIDDLE_Y] + np.float32(j) * sides[1]
                z = box[MIDDLE_Z] + np.float32(k) * sides[2]
                near = False
                if solid:
                    ox, oy, oz = outside(x, y, z, wide, solids)
                    near = (ox != x) | (oy != y) | (oz != z) | occupied(cells, counts, i, j, k)
                    if near:
                        x, y, z = outside(x, y, z, skin + skin, solids)
                mean = ZERO
                vx = ZERO
                vy = ZERO
                vz = ZERO
                for low in range(0, ways.shape[0], W):
                    n = min(ways.shape[0] - low, W)
                    for d in range(n):
                        work[LX + d] = ways[low + d, 0]
                        work[LY + d] = ways[low + d, 1]
                        work[LZ + d] = ways[low + d, 2]
                        work[LIGHT + d] = np.float32(left[low + d, cell])
                    if near:
                        occlude(work, n, x, y, z, solids, skin)
                    for d in range(n):
                        light = work[LIGHT + d]
                        mean += light
                        vx += light * work[LX + d]
                        vy += light * work[LY + d]
                        vz += light * work[LZ + d]
                volume[cell, MEAN] = mean * per
                volume[cell, SLOPE_X] = THREE * vx * per
                volume[cell, SLOPE_Y] = THREE * vy * per
                volume[cell, SLOPE_Z] = THREE * vz * per


@device
def occlude(work, n, x, y, z, solids, skin):
    """Set the row `LIGHT` of the first n directions to 0 where a solid occludes the light: vectorised
    `rays.visibility`."""
    past_round(solids, work, n, x, y, z, skin)
    by_lanes = other.takes_vectors(solids)
    if by_lanes:
        past_distances(work, n, x, y, z, solids, skin)
    further = flat_or_other(solids)
    for d in range(n):
        if further and work[LIGHT + d] > ZERO:
            lx, ly, lz = work[LX + d], work[LY + d], work[LZ + d]
            ox, oy, oz = x + skin * lx, y + skin * ly, z + skin * lz
            if by_lanes:
                work[LIGHT + d] *= rays.visibility_past_planes(solids, ox, oy, oz, lx, ly, lz, FAR, skin)
            else:
                work[LIGHT + d] *= rays.visibility_past_flat(solids, ox, oy, oz, lx, ly, lz, FAR, skin)


@device
def past_distances(work, n, x, y, z, solids, skin):
    """Set the row `LIGHT` to 0 where solids of other shapes occlude the light, by their distances along rays: as soft
    shadows do, of a light without a size. That takes a tenth of the time of rays that meet triangles, and is as exact
    as light that varies from cell to cell needs."""
    rows = pointer(work)
    for d in range(n, -(-n // lane_count(rows)) * lane_count(rows)):  # nothing to look for
        work[LIGHT + d] = ZERO
    for d in range(0, n, lane_count(rows)):
        light = load(rows, LIGHT + d)
        way = load3(rows, LX + d, W)
        point = broadcast(light, x), broadcast(light, y), broadcast(light, z)
        reach, size = broadcast(light, FAR), broadcast(light, penumbra.SHARP)
        least = where(light > ZERO, ONE, -ONE * size)
        least = other.lowest_sines(solids, least, point, way, (reach, size, skin))
        store(rows, LIGHT + d, where(least > ZERO, light, ZERO))


@device_if_built_in(lambda solids: True)
def flat_or_other(solids):
    """Return whether there are other solids than spheres and capsules."""
    return count_solids(solids) > solids.spheres.shape[0] + solids.capsules.shape[0]


@device_if_built_in(lambda solids, work, n, x, y, z, skin: None)
def past_round(solids, work, n, x, y, z, skin):
    """Set the row `LIGHT` to 0 where a sphere or a capsule occludes the light."""
    for s in range(solids.spheres.shape[0]):
        for d in range(n):
            work[LIGHT + d] *= sphere.visibility(
                solids.spheres, s, x, y, z, work[LX + d], work[LY + d], work[LZ + d], FAR, skin
            )
    for s in range(solids.capsules.shape[0]):
        beside = np.int64(0)
        for d in range(n):
            ox, oy, oz = x + skin * work[LX + d], y + skin * work[LY + d], z + skin * work[LZ + d]
            free = capsule.misses_ball(solids.capsules, s, ox, oy, oz, work[LX + d], work[LY + d], work[LZ + d])
            beside += np.int64(free | (work[LIGHT + d] == ZERO))
        if beside < n:
            for d in range(n):
                ox, oy, oz = x + skin * work[LX + d], y + skin * work[LY + d], z + skin * work[LZ + d]
                t = capsule.meet(solids.capsules, s, ox, oy, oz, work[LX + d], work[LY + d], work[LZ + d])
                work[LIGHT + d] *= ZERO if (skin < t) & (t < FAR) else ONE


@device
def occupied(cells, counts, i, j, k):
    """Return whether a cell or one of its neighbours contains strands."""
    for a in range(max(i - 1, 0), min(i + 2, counts[0])):
        for b in range(max(j - 1, 0), min(j + 2, counts[1])):
            for c in range(max(k - 1, 0), min(k + 2, counts[2])):
                if cells[(a * counts[1] + b) * counts[2] + c, DENSITY] > ZERO:
                    return True
    return False
