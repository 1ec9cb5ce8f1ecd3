"""What the strands around do to a strand: friction toward the grid's velocity, and pressure.

Both change the velocity that a step begins with, and so take part in its iterations. A strand loses a share of its
velocity against the cells', an average of velocities: it can gain no energy, however great the share. What it loses
others gain, for a cell's velocity is its momentum over its mass, by the same weights. The impulse of pressure on the
face of two cells is shared by their masses. So sums of momentum stay, to rounding.
"""

from __future__ import annotations

import numpy as np

from ...jit import device, parallel, prange
from ...simd import broadcast, lane, lane_count, load, pointer, quarter_width_pointer, store
from .crowd_grid import cell_of, locate, three
from .crowd_records import CELL, FIRST, LAST, MASS, MOMENTUM, RATE, RESULT, SHARE, SIZE, TARGET, VELOCITY
from .rod_scratch import PACK

EMPTY = np.float32(1e-30)
"""Metres in a cell up to which it is empty."""


@parallel
def find_targets(box, grid, room, numbers, pressure, targets):
    """Set ``targets`` (cells, `CELL`). ``numbers``: metres in a cell that is as dense as allowed; the share of its
    velocity against such a cell that a strand loses in the step; the cell's side over the step, m/s."""
    full, share, speed = numbers
    push = speed * full
    wide, high, deep = box[SIZE], box[SIZE + 1], box[SIZE + 2]
    layer = wide * high
    for o in prange(deep):
        for n in range(high):
            row = o * layer + n * wide
            for i in range(wide):
                at = row + i
                m = grid[at, MASS]
                rate = share * min(m / full, np.float32(1))
                f = rate / max(m, EMPTY)
                x = push_along(at, 1, i, wide, grid, pressure, room.open)
                y = push_along(at, wide, n, high, grid, pressure, room.open)
                z = push_along(at, layer, o, deep, grid, pressure, room.open)
                targets[at, RATE] = rate
                targets[at, TARGET] = f * grid[at, MOMENTUM] + push * x
                targets[at, TARGET + 1] = f * grid[at, MOMENTUM + 1] + push * y
                targets[at, TARGET + 2] = f * grid[at, MOMENTUM + 2] + push * z


@device
def push_along(at, stride, i, count, grid, pressure, open):
    """Change of velocity by pressure along an axis, in cells a step for each metre in a cell."""
    x = np.float32(0)
    if open[at] > 0:
        own, m = pressure[at], grid[at, MASS]
        if i > 0 and open[at - stride] > 0:
            x += (pressure[at - stride] - own) / max(grid[at - stride, MASS] + m, EMPTY)
        if i < count - 1 and open[at + stride] > 0:
            x += (own - pressure[at + stride]) / max(m + grid[at + stride, MASS], EMPTY)
    return x


@parallel
def accelerate(moving, lattice, parts, box, targets, scratch, crowd):
    """Set the accelerations of particles, ``crowd`` (P, N, 3 S)."""
    for part in prange(len(parts)):
        for pack in range(parts[part, FIRST], parts[part, LAST]):
            crowd[pack] = 0
            accelerate_pack(moving, lattice, pack, box, targets.reshape(-1), scratch[part], crowd)


@device
def accelerate_pack(moving, lattice, pack, box, targets, rows, crowd):
    """Add the accelerations of a pack's particles: each sample's change of momentum goes to the particles of which it
    is a mean, by their shares. What goes to the root the emitter takes up."""
    wide = box[SIZE] * CELL
    layer = wide * box[SIZE + 1]
    cells = quarter_width_pointer(targets)
    for sample in range(len(lattice.first)):
        locate(moving, lattice, pack, sample, box, lattice.origins[-1], rows)
        for k in range(PACK):
            a, c, d = three(rows, SHARE, k)
            at = cell_of(rows, k, wide, layer)
            found = blend(cells, at, np.uint64(wide), np.uint64(layer), a, c, d)
            for column in range(CELL):
                rows[RESULT + column, k] = lane(found, column)
        share_out(moving, lattice, pack, sample, rows, crowd)


@device
def share_out(moving, lattice, pack, sample, rows, crowd):
    """Add what a sample's velocity changes by to the accelerations of its particles."""
    read, out = pointer(rows), pointer(crowd)
    n = crowd.shape[1]
    first, m = lattice.first[sample], lattice.mass[sample] / lattice.step
    for k in range(0, PACK, lane_count(read)):
        rate = load(read, RESULT * PACK + k)
        for c in range(3):
            change = load(read, (RESULT + 1 + c) * PACK + k) - rate * load(read, (VELOCITY + c) * PACK + k)
            for i in range(max(1 - first, 0), lattice.counts[sample]):
                j = first + i - 1
                at = ((pack * n + j) * 3 + c) * PACK + k
                store(out, at, load(out, at) + m * lattice.weights[sample, i] / moving.mass[j] * change)


@device
def blend(cells, at, wide, layer, a, c, d):
    """The columns of targets interpolated between eight cells, of which ``at`` is the first."""
    one = np.float32(1)
    e, f = one - d, d
    sums = broadcast(cells, 0.0)
    sums = blend_row(cells, at, a, e * (one - c), sums)
    sums = blend_row(cells, at + wide, a, e * c, sums)
    sums = blend_row(cells, at + layer, a, f * (one - c), sums)
    return blend_row(cells, at + layer + wide, a, f * c, sums)


@device
def blend_row(cells, at, a, weight, sums):
    """Sums plus those of two neighbouring cells, of which the second has the share ``a`` of the weight."""
    f = weight * a
    return sums + (weight - f) * load(cells, at) + f * load(cells, at + np.uint64(CELL))


assert CELL == TARGET + 3
