"""What the strands around do to a strand: friction toward the grid's velocity, and pressure.

Both change the velocity that a step begins with, and so take part in its iterations. A strand loses a share of its
velocity against the cells', an average of velocities: it can gain no energy, however great the share. What it loses
others gain, for a cell's velocity is its momentum over its mass, by the same weights. The impulse of pressure on the
face of two cells is shared by masses, half of it by those of both cells, half by what lies between their middles. So
sums of momentum stay, to rounding.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, parallel, prange
from ....simd import gather4, half_width_pointer, lane_count, load, load3, pointer, sqrt, store, store3
from ...rod.kernels.arrays import AXES, PACK
from .donor_cells import read_home, settle
from .limit import limit
from .nodes import keep_others
from .pressure import find_excess, relax
from .records import (
    CELL,
    COUNTED,
    FIRST,
    FOUND,
    FULL,
    HANDED,
    LANES,
    LAST,
    MASS,
    OF_ROOT,
    PUSH,
    RESULT,
    SHARE,
    SIZE,
    STOP,
    VELOCITY,
    WAY,
)
from .shelter import shelter
from .targets import find_targets
from .transfer import cell_of, locate, three, weights_along


@parallel
def act(box, grid, near, room, numbers, work, met, pressure, targets, others):
    """Set ``pressure`` (cells,), from that of the step before, and ``targets`` (cells, `CELL`), and ``others``, as
    `find_targets` does. Where there are solids,
    set `Room.open` and return the most metres in a cell by what is open of it, else 0.

    ``met``: the share of each cell that is outside of solids (cells,), and what `donor_cells.settle` takes; no rows
    where there are none. A density of `FULL` that is 0 is set to those most metres.
    ``near``: as `pressure.relax` takes it; ``work``: what that takes and, where there is wind, the layers that
    `shelter.shelter` takes; ``numbers`` (`NUMBERS`,) float32. Pressure and shelter follow from their own
    neighbours, cell by cell: a thread finds one of them while another finds the other. No strand is in rows that are
    not ``near``: what else those hold is neither set nor read.
    """
    margined, busy, layers = work
    shares, homes, closed = met
    most = np.float32(0)
    if len(homes) > 0:
        for at in range(0, len(shares), LANES):
            store(pointer(room.open), at, load(pointer(shares), at))
        most = settle(box, near, grid, room.open, homes, closed)
        for at in range(0, len(shares), LANES):
            store(pointer(room.aperture), at, sqrt(max(load(pointer(room.open), at), 0.0)))
        if numbers[FULL] == 0:
            numbers[FULL] = most
    drop_far(box, near, pressure)
    for o in prange(box[SIZE + 2]):
        find_excess(box, np.int64(o), near, grid, room, pressure, numbers)
    for task in prange(2):
        if task == 0:
            relax(box, room, near, margined, busy, pressure)
            limit(box, busy, grid, room, numbers, pressure)
        elif len(room.left) > 0:
            shelter(box, grid[MASS], numbers[WAY : WAY + 3], numbers[STOP], room.left, layers)
    for o in prange(box[SIZE + 2]):
        find_targets(box, np.int64(o), near, grid, room, numbers, pressure, targets, others)
    if len(homes) > 0:
        read_home(box, homes, closed, targets)
    return most


@device
def drop_far(box, near, pressure):
    """Set the pressure of rows that are not ``near`` to 0."""
    wide, high = box[SIZE], box[SIZE + 1]
    for row in range(high * box[SIZE + 2]):
        if not near[row // high, row % high]:
            for at in range(row * wide, (row + 1) * wide, LANES):
                store(pointer(pressure), at, 0.0)


@parallel
def accelerate(moving, lattice, parts, box, targets, work, shares, accelerations, handed):
    """Set the ``accelerations`` of particles (P, N, 3 S), and what `note_handed` and `keep_others` do. ``work``:
    scratch, as `transfer.deposit` takes it; ``shares`` (samples, greatest count): of a sample's change that its
    particles have, 1/s; ``handed``: as `HANDED` says."""
    scratch, found = work
    for part in prange(len(parts)):
        for pack in range(parts[part, FIRST], parts[part, LAST]):
            rows = scratch[part], found[part]
            accelerate_pack(moving, lattice, (pack, pack + 1), box, targets.reshape(-1), rows, shares, accelerations)
            note_handed(pack, lattice.step, rows[0], moving.mass, accelerations, handed)
            keep_others(moving, lattice, (pack, pack + 1), lattice.step, lattice.seen * lattice.step, accelerations)


@device
def accelerate_pack(moving, lattice, packs, box, targets, work, shares, accelerations):
    """Set the accelerations of a pack's particles: each sample's change of momentum goes to the particles of which it
    is a mean, by their shares. What goes to the root is left in the rows of scratch: the emitter takes it up.
    ``packs``: as `locate` takes them."""
    wide = np.uint64(box[SIZE] * CELL)
    layer = wide * np.uint64(box[SIZE + 1])
    cells, (rows, found), begun = half_width_pointer(targets), work, np.int64(0)
    read = half_width_pointer(found)
    rows[OF_ROOT : OF_ROOT + 3] = 0
    for sample in range(len(lattice.first)):
        locate(moving, lattice, packs, sample, box, lattice.origins[-1], rows)
        for k in range(PACK):
            a, c, d = three(rows, SHARE, k)
            store(read, k * CELL, blend(cells, cell_of(rows, k), wide, layer, a, c, d))
        rate, u, v, w = gather4(pointer(found), 0, load(pointer(COUNTED), 0), CELL, 0.0)
        x, y, z, _ = gather4(pointer(found), PUSH, load(pointer(COUNTED), 0), CELL, 0.0)
        store(pointer(found), CELL * PACK, rate)
        store3(pointer(found), (CELL + 1) * PACK, PACK, u + x, v + y, w + z)
        for c in range(FOUND - CELL):
            for k in range(PACK):
                rows[RESULT + c, k] = found[(CELL + c) * PACK + k]
        begun = share_out(lattice, packs[0], sample, rows, shares[sample], begun, accelerations)


@device
def share_out(lattice, pack, sample, rows, shares, begun, accelerations):
    """Add what a sample's velocity changes by to the accelerations of its particles, of which so many have ``begun``,
    and to that of the root's share; return how many have then."""
    read, out = pointer(rows), pointer(accelerations)
    n, first, count = accelerations.shape[1], lattice.first[sample] - 1, lattice.counts[sample]
    for k in range(0, PACK, lane_count(read)):
        rate = load(read, RESULT * PACK + k)
        x = load(read, (RESULT + 1) * PACK + k) - rate * load(read, VELOCITY * PACK + k)
        y = load(read, (RESULT + 2) * PACK + k) - rate * load(read, (VELOCITY + 1) * PACK + k)
        z = load(read, (RESULT + 3) * PACK + k) - rate * load(read, (VELOCITY + 2) * PACK + k)
        if first < 0:
            of_root = OF_ROOT * PACK + k
            u, v, w = load3(read, of_root, PACK)
            store3(read, of_root, PACK, u + shares[0] * x, v + shares[0] * y, w + shares[0] * z)
        for i in range(max(-first, 0), count):
            at, share = (pack * n + first + i) * 3 * PACK + k, shares[i]
            if first + i < begun:
                u, v, w = load3(out, at, PACK)
                store3(out, at, PACK, u + share * x, v + share * y, w + share * z)
            else:
                store3(out, at, PACK, share * x, share * y, share * z)
    return first + count


@device
def blend(cells, at, wide, layer, a, c, d):
    """The columns of targets interpolated between eight cells, of which ``at`` is the first."""
    x, x_next = weights_along(cells, 0, a)
    y, y_next = weights_along(cells, 1, c)
    z, z_next = weights_along(cells, 2, d)
    sums = y * z * blend_row(cells, at, x, x_next)
    sums += y_next * z * blend_row(cells, at + wide, x, x_next)
    sums += y * z_next * blend_row(cells, at + layer, x, x_next)
    return sums + y_next * z_next * blend_row(cells, at + layer + wide, x, x_next)


@device
def blend_row(cells, at, x, x_next):
    """Interpolate along x."""
    return x * load(cells, at) + x_next * load(cells, at + np.uint64(CELL))


@device
def note_handed(pack, step, rows, mass, accelerations, handed):
    """Add what the ``accelerations`` of a pack's particles (P, N, 3 S), and what ``rows`` of scratch have of
    their roots, do to the momentum of its strands in a step, ``handed``."""
    read, change, out = pointer(rows), pointer(accelerations), pointer(handed)
    n = accelerations.shape[1]
    for k in range(0, PACK, lane_count(change)):
        first = mass[0] * step
        u, v, w = load3(read, OF_ROOT * PACK + k, PACK)
        u, v, w = first * u, first * v, first * w
        for j in range(n):
            m = mass[j] * step
            a, b, c = load3(change, (pack * n + j) * AXES + k, PACK)
            u, v, w = u + m * a, v + m * b, w + m * c
        at = pack * HANDED * PACK + k
        a, b, c = load3(out, at, PACK)
        store3(out, at, PACK, a + u, b + v, c + w)
        store(out, at + AXES, load(out, at + AXES) + sqrt(u * u + v * v + w * w))
