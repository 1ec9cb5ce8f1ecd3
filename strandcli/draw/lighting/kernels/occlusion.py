"""Ambient occlusion by a grid of cells: strands counted in them, swept from many directions, looked up at points.

Of its strands a cell holds ρ = Σ width · length / volume and M, the same sum over the squares t tᵀ of their directions.
Across a direction ω such strands cover σ = √(ρ² − ρ ωᵀM ω) of each metre (Heitz et al. 2015, "The SGGX Microflake
Distribution"): exactly where they are parallel, 4 % too much where they lie in all directions. The light that is left
is swept from slab to slab against ω, interpolated between the cells of the slab before (short characteristics, Kunasz &
Auer 1988), which spreads it sideways by a cell now and then.
"""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, function, parallel, prange
from ....solids.kernels import capsule, sphere
from ....solids.kernels.outside import count as count_solids
from ....solids.kernels.outside import outside
from ...common.kernels.approximations import exp
from ...solids.kernels import rays

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
THREE = np.float32(3.0)
LEVELS = np.float32(255.0)
FAR = np.float32(1e30)
COSINE = np.float32(2.0 / 3.0)
"""Share of the linear part of what is seen that counts for a surface, which weighs it by the cosine."""
LX, LY, LZ, LIGHT = (i * W for i in range(4))
ROWS = 4
"""Rows of numbers, one a direction: where to, and what of its light arrives."""
CHANNELS = 7
"""Of a cell: ρ, and M's xx, xy, xz, yy, yz, zz."""


@function
def count(positions, strands, step, width, taper, scale, weight, box, cells):
    """Add every step-th strand of positions (blocks, n + 1, 3 W) to the cells (V, 7), times ``weight``.

    width: metres at the root, of which `taper` is lost to the tip; scale (strands,): factor of each, or None;
    box (10,) float32: the middle of the first cell, cells a metre along x, y, z, cells along each, and metres
    beyond the box over which occlusion falls to a fourth.
    """
    n = positions.shape[1] - 1
    for s in range(np.int64(0), strands, step):
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
                w = own * (ONE - taper * (np.float32(j) - np.float32(1.5)) / np.float32(n - 1))
                piece(x, y, z, dx, dy, dz, length, w, box, cells)
            x += dx
            y += dy
            z += dz


@device
def piece(x, y, z, dx, dy, dz, length, width, box, cells):
    """A straight piece of a strand, a sample for each cell that it crosses along its longest way."""
    most = max(max(abs(dx) * box[3], abs(dy) * box[4]), abs(dz) * box[5])
    steps = np.ceil(min(most, np.float32(1e4))) + ONE
    per = ONE / steps
    share = width * length * per
    tx = dx / length
    ty = dy / length
    tz = dz / length
    for i in range(np.int64(steps)):
        t = (np.float32(i) + HALF) * per
        a = place(x + t * dx, box, 0)
        b = place(y + t * dy, box, 1)
        c = place(z + t * dz, box, 2)
        cell = (a * np.int64(box[7]) + b) * np.int64(box[8]) + c
        cells[cell, 0] += share
        cells[cell, 1] += share * tx * tx
        cells[cell, 2] += share * tx * ty
        cells[cell, 3] += share * tx * tz
        cells[cell, 4] += share * ty * ty
        cells[cell, 5] += share * ty * tz
        cells[cell, 6] += share * tz * tz


@device
def place(x, box, axis):
    """Number of the cell along an axis; the outermost takes what is beyond."""
    u = (x - box[axis]) * box[3 + axis] + HALF
    return np.int64(min(max(u, ZERO), box[6 + axis] - ONE))


@parallel
def sweep(cells, counts, sides, ways, left):
    """What strands leave of the light from each direction.

    cells (V, 7) in 1/m; counts (3,) int64; sides (3,) metres of a cell; ways (K, 3) unit vectors toward the light;
    left (K, V) uint8: 255 where all of it arrives at a cell's middle.
    """
    for way in prange(ways.shape[0]):
        d = np.int64(way)
        axis = np.int64(0)  # a literal would have all that follows compiled twice
        for k in range(1, 3):
            if abs(ways[d, k]) * sides[axis] > abs(ways[d, axis]) * sides[k]:
                axis = k
        one = 1 if axis == 0 else 0
        two = 1 if axis == 2 else 2
        size = (counts[one] + 2) * (counts[two] + 2)
        before = np.ones(size, np.float32)
        after = np.ones(size, np.float32)
        thick = np.zeros(size, np.float32)
        thicker = np.zeros(size, np.float32)
        across(cells, counts, sides, ways, d, axis, one, two, before, after, thick, thicker, left)


@device
def across(cells, counts, sides, ways, d, axis, one, two, before, after, thick, thicker, left):
    """`sweep` of one direction, slab by slab along the axis on which it crosses most cells; what is left and how thick
    it is before and after a slab."""
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
    row = counts[two] + 2
    for m in range(counts[axis]):
        slab = (counts[axis] - 1 - m if ways[d, axis] > ZERO else m) * down
        for p in range(counts[one]):
            base = slab + p * along
            own = (p + 1) * row + 1
            up = (p + 1 + low_f) * row + 1 + low_g
            for q in range(counts[two]):
                cell = base + q * beside
                r = cells[cell, 0]
                inside = x * x * cells[cell, 1] + y * y * cells[cell, 4] + z * z * cells[cell, 6]
                inside += (ONE + ONE) * (x * y * cells[cell, 2] + x * z * cells[cell, 3] + y * z * cells[cell, 5])
                thicker[own + q] = math.sqrt(max(r * (r - inside), ZERO))
            for q in range(counts[two]):
                came = mixed(before, up + q, row, f, g)
                met = half * (thicker[own + q] + mixed(thick, up + q, row, f, g))
                after[own + q] = came * exp(-met)
            for q in range(counts[two]):
                left[d, base + q * beside] = np.uint8(after[own + q] * LEVELS + HALF)
        before, after = after, before
        thick, thicker = thicker, thick


@device
def mixed(plane, at, row, f, g):
    """Bilinear in a plane, from the place `at`."""
    upper = plane[at] + g * (plane[at + 1] - plane[at])
    lower = plane[at + row] + g * (plane[at + row + 1] - plane[at + row])
    return upper + f * (lower - upper)


@parallel
def combine(cells, counts, sides, box, ways, left, solids, volume):
    """Of what strands and solids leave of each direction, the mean and thrice the mean times the direction.

    As in `sweep`; solids packed; volume (V, 4): V(ω) = v₀ + v · ω, the best linear fit. A middle inside of a solid
    stands for the nearest point of its surface. Only cells with strands about them, or near a surface, ask for solids:
    others are never looked up.
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
                x = box[0] + np.float32(i) * sides[0]
                y = box[1] + np.float32(j) * sides[1]
                z = box[2] + np.float32(k) * sides[2]
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
                        hide(work, n, x, y, z, solids, skin)
                    for d in range(n):
                        light = work[LIGHT + d]
                        mean += light
                        vx += light * work[LX + d]
                        vy += light * work[LY + d]
                        vz += light * work[LZ + d]
                volume[cell, 0] = mean * per
                volume[cell, 1] = THREE * vx * per
                volume[cell, 2] = THREE * vy * per
                volume[cell, 3] = THREE * vz * per


@device
def hide(work, n, x, y, z, solids, skin):
    """No light from the first n directions where a solid stands between: `rays.lit` of each, row by row."""
    for s in range(solids.spheres.shape[0]):
        for d in range(n):
            work[LIGHT + d] *= sphere.past(
                solids.spheres, s, x, y, z, work[LX + d], work[LY + d], work[LZ + d], FAR, skin
            )
    for s in range(solids.capsules.shape[0]):
        beside = np.int64(0)
        for d in range(n):
            ox, oy, oz = x + skin * work[LX + d], y + skin * work[LY + d], z + skin * work[LZ + d]
            free = capsule.passes(solids.capsules, s, ox, oy, oz, work[LX + d], work[LY + d], work[LZ + d])
            beside += np.int64(free | (work[LIGHT + d] == ZERO))
        if beside < n:
            for d in range(n):
                ox, oy, oz = x + skin * work[LX + d], y + skin * work[LY + d], z + skin * work[LZ + d]
                t = capsule.meet(solids.capsules, s, ox, oy, oz, work[LX + d], work[LY + d], work[LZ + d])
                work[LIGHT + d] *= ZERO if (skin < t) & (t < FAR) else ONE
    others = count_solids(solids) - solids.spheres.shape[0] - solids.capsules.shape[0]
    for d in range(n):
        if others > 0 and work[LIGHT + d] > ZERO:
            ox, oy, oz = x + skin * work[LX + d], y + skin * work[LY + d], z + skin * work[LZ + d]
            work[LIGHT + d] *= rays.past_flat(
                solids, ox, oy, oz, work[LX + d], work[LY + d], work[LZ + d], FAR, skin
            )


@device
def occupied(cells, counts, i, j, k):
    """Whether a cell or one beside it holds a strand."""
    for a in range(max(i - 1, 0), min(i + 2, counts[0])):
        for b in range(max(j - 1, 0), min(j + 2, counts[1])):
            for c in range(max(k - 1, 0), min(k + 2, counts[2])):
                if cells[(a * counts[1] + b) * counts[2] + c, 0] > ZERO:
                    return True
    return False


@device
def corner(u, count):
    """The lower of two neighbouring cells, and the part of the way to the other."""
    u = min(max(u, ZERO), count - ONE)
    low = min(np.int64(u), np.int64(count) - 2)
    return low, u - np.float32(low)


@function
def seen(volume, box, x, y, z, nx, ny, nz):
    """Share of the light from everywhere that strands and solids leave a point: of the sphere with n = 0, for a
    strand, or of a surface's half, weighed by the cosine to its normal n."""
    u = (x - box[0]) * box[3]
    v = (y - box[1]) * box[4]
    w = (z - box[2]) * box[5]
    i, a = corner(u, box[6])
    j, b = corner(v, box[7])
    k, c = corner(w, box[8])
    rows = np.int64(box[8])
    slabs = np.int64(box[7]) * rows
    base = i * slabs + j * rows + k
    share = ZERO
    for channel in range(4):
        weight = ONE
        if channel > 0:
            weight = COSINE * (nx if channel == 1 else (ny if channel == 2 else nz))
        p = volume[base, channel] + c * (volume[base + 1, channel] - volume[base, channel])
        at = base + rows
        q = volume[at, channel] + c * (volume[at + 1, channel] - volume[at, channel])
        first = p + b * (q - p)
        at = base + slabs
        p = volume[at, channel] + c * (volume[at + 1, channel] - volume[at, channel])
        at += rows
        q = volume[at, channel] + c * (volume[at + 1, channel] - volume[at, channel])
        last = p + b * (q - p)
        share += weight * (first + a * (last - first))
    beyond = past(u, box[6]) / box[3] + past(v, box[7]) / box[4] + past(w, box[8]) / box[5]
    fall = box[9] / (box[9] + beyond)
    return ONE - fall * fall * (ONE - min(max(share, ZERO), ONE))


@device
def past(u, count):
    """Cells by which a place is beyond the box."""
    return max(max(-u, u - (count - ONE)), ZERO)
