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
from ....jit import device, function, parallel, prange
from ....jit.indices import FIRST, SECOND, THIRD
from ....solids.kernels.outside import count as count_solids
from ...common.kernels import batch
from ...common.kernels.approximations import exp
from ...common.kernels.numbers import HALF, ONE, THREE, ZERO
from . import occlusion
from .occlusion import DENSITY, MEAN, SLOPE_X, SLOPE_Y, SLOPE_Z, XX, XY, XZ, YY, YZ, ZZ
from .occlusion_solids import Listed, hide

NEXT = np.uint64(1)
LEVELS = np.float32(255.0)


class Planes(NamedTuple):
    """Light in two slabs and extinction in all, padded by one cell on each side; float32."""

    before: NDArray[np.float32]
    """Transmitted light in the previous slab, 0 to 1."""
    after: NDArray[np.float32]
    """Transmitted light in this slab."""
    thick: NDArray[np.float32]
    """Extinction, 1/m, slab after slab along the axis; before the first and after the last one without any."""


@parallel
def sweep(cells, counts, sides, directions, left):
    """Write the transmittance of strands toward each direction to left (K, V) uint8, 255 for 1, at the cells' centres.

    cells (V, CHANNELS), 1/m; counts (3,) int64; sides (3,): sides of a cell, metres; directions (K, 3): unit vectors
    toward the light, of which the second half are the opposites of the first, with the same extinction.
    """
    half = directions.shape[0] // 2
    for number in prange(half):
        d = np.int64(number)
        axis = np.int64(0)  # with a literal, Numba would compile the functions below twice
        for k in range(1, 3):
            if abs(directions[d, k]) * sides[axis] > abs(directions[d, axis]) * sides[k]:
                axis = k
        one = 1 if axis == 0 else 0
        two = 1 if axis == 2 else 2
        size = (counts[one] + 2) * (counts[two] + 2)
        thick = np.zeros((counts[axis] + 2) * size, np.float32)
        measure(cells, counts, directions, d, axis, one, two, thick)
        for side in range(2):
            planes = Planes(np.ones(size, np.float32), np.ones(size, np.float32), thick)
            sweep_direction(counts, sides, directions, d + side * half, axis, one, two, planes, left)


@device
def measure(cells, counts, directions, d, axis, one, two, thick):
    """Write the extinction along direction d to `Planes.thick`."""
    down, along, beside = stride_of(counts, axis), stride_of(counts, one), stride_of(counts, two)
    x, y, z = directions[d, 0], directions[d, 1], directions[d, 2]
    row = np.uint64(counts[two] + 2)  # as places in planes, which cannot be negative: these loops are vectors
    size = np.uint64(counts[one] + 2) * row
    for m in range(counts[axis]):
        for p in range(counts[one]):
            base = m * down + p * along
            own = np.uint64(m + 1) * size + np.uint64(p + 1) * row + NEXT
            for q in range(np.uint64(counts[two])):
                cell = np.uint64(base) + q * np.uint64(beside)
                r = cells[cell, DENSITY]
                inside = x * x * cells[cell, XX] + y * y * cells[cell, YY] + z * z * cells[cell, ZZ]
                inside += (ONE + ONE) * (x * y * cells[cell, XY] + x * z * cells[cell, XZ] + y * z * cells[cell, YZ])
                thick[own + q] = math.sqrt(max(r * (r - inside), ZERO))


@device
def stride_of(counts, axis):
    """Return the number of cells from one to the next along an axis."""
    return counts[1] * counts[2] if axis == 0 else (counts[2] if axis == 1 else np.int64(1))


@device
def sweep_direction(counts, sides, directions, d, axis, one, two, planes, left):
    """Run `sweep` for direction d, slab by slab along `axis`, on which it crosses most cells; one, two: other axes."""
    before, after, thick = planes.before, planes.after, planes.thick
    down, along, beside = stride_of(counts, axis), stride_of(counts, one), stride_of(counts, two)
    steep = abs(directions[d, axis])
    half = HALF * sides[axis] / steep
    ratio = sides[axis] / steep
    f = directions[d, one] / sides[one] * ratio
    g = directions[d, two] / sides[two] * ratio
    low_f = np.int64(min(np.floor(f), ZERO))
    low_g = np.int64(min(np.floor(g), ZERO))
    f -= np.float32(low_f)
    g -= np.float32(low_g)
    row = np.uint64(counts[two] + 2)
    size = np.uint64(counts[one] + 2) * row
    back = directions[d, axis] > ZERO
    for m in range(counts[axis]):
        slab = (counts[axis] - 1 - m if back else m) * down
        here = np.uint64(counts[axis] - m if back else m + 1) * size
        last = here + size if back else here - size
        for p in range(counts[one]):
            base = slab + p * along
            own = np.uint64(p + 1) * row + NEXT
            up = np.uint64(p + 1 + low_f) * row + np.uint64(1 + low_g)
            for q in range(np.uint64(counts[two])):
                came = mixed(before, up + q, row, f, g)
                met = half * (thick[here + own + q] + mixed(thick, last + up + q, row, f, g))
                after[own + q] = came * exp(-met)
            for q in range(np.uint64(counts[two])):
                left[d, np.uint64(base) + q * np.uint64(beside)] = np.uint8(after[own + q] * LEVELS + HALF)
        before, after = after, before


@device
def mixed(plane, at, row, f, g):
    """Interpolate bilinearly in a plane; at: index of the upper left cell; row: cells a row."""
    upper = plane[at] + g * (plane[at + NEXT] - plane[at])
    lower = plane[at + row] + g * (plane[at + row + NEXT] - plane[at + row])
    return upper + f * (lower - upper)


@parallel
def combine(cells, counts, sides, box, directions, left, solids, volume):
    """Write the linear fit V(ω) = v₀ + v · ω of each cell's visibility past strands and solids to volume (V, 4): v₀ is
    the mean over directions, v three times the mean of visibility times direction.

    Arguments as in `sweep`, where `left` is set to 0 where solids hide the sky (`hide`); solids: packed.
    """
    size = counts[1] * counts[2]
    solid = count_solids(solids) > 0
    for slab in prange(counts[0]):
        i = np.int64(slab)
        if solid:
            listed = Listed(
                np.zeros(batch.ROWS * W, np.float32), np.empty(W, np.int64),
                left.reshape(-1), np.empty((size, 4), np.float32),
            )  # fmt: skip
            hide(cells, counts, sides, box, directions, listed, solids, i)
        work = np.empty(4 * W, np.float32)
        for low in range(0, size, W):
            fit(directions, left, i * size + low, min(size - low, W), work, volume)


@device
def fit(directions, left, first, n, work, volume):
    """Run `combine` for n cells; work: 4 W numbers."""
    per = ONE / (LEVELS * np.float32(directions.shape[0]))
    first, n = np.uint64(first), np.uint64(n)
    mean, slope_x, slope_y, slope_z = work[:W], work[W : 2 * W], work[2 * W : 3 * W], work[3 * W :]
    work[:] = ZERO
    for d in range(directions.shape[0]):
        x, y, z = directions[d, 0], directions[d, 1], directions[d, 2]
        for q in range(n):
            light = np.float32(left[d, first + q])
            mean[q] += light
            slope_x[q] += light * x
            slope_y[q] += light * y
            slope_z[q] += light * z
    for q in range(n):
        volume[first + q, MEAN] = mean[q] * per
        volume[first + q, SLOPE_X] = THREE * slope_x[q] * per
        volume[first + q, SLOPE_Y] = THREE * slope_y[q] * per
        volume[first + q, SLOPE_Z] = THREE * slope_z[q] * per


@function
def count_strands(positions, chosen, width, taper, scale, shares, weight, box, cells):
    """Add the strands chosen (N,) int64 of positions (blocks, n + 1, 3 W) to the cells (V, CHANNELS), times ``weight``.

    width: metres at the root, smaller by the share `taper` at the tip; scale (strands,): factor of each strand's width,
    or None; shares (strands, n): of that at each point, in place of the taper, or None; box (`BOX_SIZE`,), cells:
    columns of `occlusion`.
    """
    n = positions.shape[1] - 1
    for s in chosen:
        block = s // W
        lane = s % W
        own = weight * (width if scale is None else width * scale[s])
        x = positions[block, 1, lane]
        y = positions[block, 1, W + lane]
        z = positions[block, 1, 2 * W + lane]
        for j in range(2, n + 1):
            dx = positions[block, j, lane] - x
            dy = positions[block, j, W + lane] - y
            dz = positions[block, j, 2 * W + lane] - z
            length = math.sqrt(dx * dx + dy * dy + dz * dz)
            if length > ZERO:
                if shares is None:
                    w = own * (ONE - taper * (np.float32(j) - np.float32(1.5)) / np.float32(n - 1))
                else:
                    w = own * (HALF * (shares[s, j - 2] + shares[s, j - 1]))
                piece(x, y, z, dx, dy, dz, length, w, box, cells)
            x += dx
            y += dy
            z += dz


@device
def piece(x, y, z, dx, dy, dz, length, width, box, cells):
    """Add a straight segment to the cells, with one sample for each cell along the axis on which it crosses most."""
    most = max(
        max(abs(dx) * box[occlusion.PER_METRE_X], abs(dy) * box[occlusion.PER_METRE_Y]),
        abs(dz) * box[occlusion.PER_METRE_Z],
    )
    steps = np.ceil(min(most, np.float32(1e4))) + ONE
    per = ONE / steps
    share = width * length * per
    tx = dx / length
    ty = dy / length
    tz = dz / length
    for i in range(np.int64(steps)):
        t = (np.float32(i) + HALF) * per
        a = place(x + t * dx, box, FIRST)
        b = place(y + t * dy, box, SECOND)
        c = place(z + t * dz, box, THIRD)
        cell = (a * np.int64(box[occlusion.COUNT_Y]) + b) * np.int64(box[occlusion.COUNT_Z]) + c
        cells[cell, occlusion.DENSITY] += share
        cells[cell, occlusion.XX] += share * tx * tx
        cells[cell, occlusion.XY] += share * tx * ty
        cells[cell, occlusion.XZ] += share * tx * tz
        cells[cell, occlusion.YY] += share * ty * ty
        cells[cell, occlusion.YZ] += share * ty * tz
        cells[cell, occlusion.ZZ] += share * tz * tz


@device
def place(x, box, axis):
    """Return the number of the cell along an axis, clamped to the grid."""
    u = (x - box[occlusion.MIDDLE_X + axis]) * box[occlusion.PER_METRE_X + axis] + HALF
    return np.int64(min(max(u, ZERO), box[occlusion.COUNT_X + axis] - ONE))
