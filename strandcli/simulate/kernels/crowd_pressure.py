"""Pressure where strands are too dense, by one-sided projection on the grid.

Density φ is relative to the greatest allowed, and f is the share of a cell that is outside of solids at the end of the
step. In a step of h with the momentum φ v that cells are going to have the density would be φ* = φ − h ∇·(φ v).
Pressure p >= 0 accelerates cells along −∇p, so that it becomes φ* + ∇²p (p here times h² over the cell's area); p is
the least with which that is nowhere more than f, and is 0 wherever there is room:

    Σ (p_c − p_d) >= e_c,    p_c >= 0,    one of both equal,    e = φ* − f,

with the sum over the faces that no solid closes. This linear complementarity problem is solved by projected
overrelaxation (Cryer 1971), which begins with the pressure of the step before. Narain et al. 2009 push granular matter
apart in the same way.

Stability. Interpolated by trilinear weights and central differences, and held by their roots, strands give way by no
more than the Laplacian foretells: no step makes up for more than what there is too much of, however long it is.

Loads. v has what all other forces changed velocities by in the last step: of a pile at rest they undo what pressure
does, and so it is found anew with φ = f, whatever the load and the step. The grid sees less of them than there is, near
surfaces and where cells are few. So only 1 − `HELD` of what they undo is seen so, and for the rest the pressure of the
step before is taken as it is. At a closed face half of a cell's momentum would be lost; it counts for the face
opposite.
"""

from __future__ import annotations

import numpy as np

from ...jit import device, function, parallel, prange
from ...simd import any_lane, broadcast, lane_count, load, pointer, store, where
from ...solids.kernels.any_depth import any_depth
from .crowd_records import LANES, LOW, SIZE

RELAXATION = np.float32(1.5)
EVEN = np.array([1, 0] * LANES, np.float32)
"""1 in lanes of even numbers."""
GROUPS = 64
"""Of cells of a row at the most: bits of a word."""
ROUNDS = 12
"""Sweeps of a step: the pressure of the step before is nearly right already."""


@function
def relax(box, excess, faces, near, work, busy, pressure):
    """Sweep over the cells `ROUNDS` times, those of one colour after those of the other, as on a chessboard.

    faces (cells,): 1 over the number of a cell's faces that no solid closes, 0 in solids; near (cells along z, along
    y): whether strands are near that row of cells, in others pressure is 0; pressure (cells,): is changed; work (cells
    along z + 2, along y + 1, along x + `LANES`): pressure with a margin of zeros, which stays, so that no cell is a
    special case: the one after a row is that before the next. Cells without pressure beside others without stay so
    unless their excess is positive: they are left out, `LANES` or a multiple of them at once. busy (2, cells along z
    + 2, along y + 2) uint64: a bit for each such group of a row, whether an excess is positive, whether a pressure is.
    """
    wide, high, deep = box[SIZE], box[SIZE + 1], box[SIZE + 2]
    stride = wide + LANES
    layer = (high + 1) * stride
    group = LANES * (wide // LANES // GROUPS + 1)
    p, e, f = pointer(work), pointer(excess), pointer(faces)
    busy[...] = 0
    for o in range(deep):
        for n in range(high):
            at, row = (o + 1) * layer + (n + 1) * stride + LANES, (o * high + n) * wide
            for i in range(0, wide, LANES):
                if near[o, n]:
                    before = load(pointer(pressure), row + i)
                    store(p, at + i, before)
                    busy[0, o + 1, n + 1] |= bit_of(load(e, row + i), i // group)
                    busy[1, o + 1, n + 1] |= bit_of(before, i // group)
                else:
                    store(p, at + i, broadcast(p, 0.0))
    for round in range(2 * ROUNDS):
        for o in range(deep):
            for n in range(high):
                if near[o, n]:
                    groups = busy[0, o + 1, n + 1] | groups_around(busy[1], o + 1, n + 1)
                    if groups != 0:
                        at, row = (o + 1) * layer + (n + 1) * stride + LANES, (o * high + n) * wide
                        sizes, colour = (stride, layer, wide, group), (o + n + round) % 2
                        busy[1, o + 1, n + 1] = relax_row(p, at, sizes, e, f, row, colour, groups)
    for o in range(deep):
        for n in range(high):
            at, row = (o + 1) * layer + (n + 1) * stride + LANES, (o * high + n) * wide
            for i in range(0, wide, LANES):
                store(pointer(pressure), row + i, load(p, at + i))


@device
def bit_of(values, place):
    """A bit at a place where some lane is positive, else 0."""
    return np.uint64(any_lane(values > 0.0)) << np.uint64(place)


@device
def groups_around(live, o, n):
    """The groups of a row, and those of the rows around it and beside them, that have pressure."""
    own = live[o, n]
    beside = own << np.uint64(1) | own >> np.uint64(1)
    return own | beside | live[o, n - 1] | live[o, n + 1] | live[o - 1, n] | live[o + 1, n]


@device
def relax_row(p, at, sizes, e, f, row, colour, groups):
    """Relax a row's cells of a colour in these groups, and return which groups have pressure then: all cells are
    computed, and those of the other colour stay as they are."""
    stride, layer, wide, group = sizes
    mine = load(pointer(EVEN), colour) > 0.0
    found = np.uint64(0)
    for i in range(0, wide, LANES):
        if groups >> np.uint64(i // group) & np.uint64(1) == 0:
            continue
        here = at + i
        around = load(p, here - 1) + load(p, here + 1)
        around += load(p, here - stride) + load(p, here + stride)
        around += load(p, here - layer) + load(p, here + layer)
        own, share = load(p, here), load(f, row + i)
        wanted = own + RELAXATION * ((load(e, row + i) + around) * share - own)
        new = where(mine, where(share > 0.0, max(wanted, 0.0), 0.0), own)
        store(p, here, new)
        found |= bit_of(new, i // group)
    return found


@parallel
def find_room(box, cell, solids, along, near, open):
    """Set the share of each cell that is outside of ``solids``, ``open`` (cells,): of what trilinear weights reach, if
    the nearest surface were a plane across an axis; 0 of cells whose middle is deeper than half a cell. ``along``:
    (cells along x,) coordinates of their middles, metres, a multiple of `LANES`, as float32; ``near`` (cells along z,
    along y): whether strands are near that row of cells, others stay as they are."""
    wide, high = box[SIZE], box[SIZE + 1]
    for o in prange(box[SIZE + 2]):
        z = np.float32(cell * (o + box[LOW + 2] + 0.5))
        for n in range(high):
            if not near[o, n]:
                continue
            y = np.float32(cell * (n + box[LOW + 1] + 0.5))
            find_room_of_row(wide, y, z, solids, np.float32(1 / cell), along, open[(o * high + n) * wide :])


@device
def find_room_of_row(wide, y, z, solids, inverse, along, open):
    """Set the open shares of a row of cells."""
    x, out = pointer(along), pointer(open)
    for i in range(0, wide, lane_count(x)):
        here = load(x, i)
        s = any_depth(solids, here, broadcast(x, y), broadcast(x, z)) * -inverse
        beyond = max(1.0 - abs(s), 0.0)
        beyond = 0.5 * beyond * beyond
        store(out, i, where(s > 0.0, 1.0 - beyond, where(s > -0.5, beyond, -beyond)))
