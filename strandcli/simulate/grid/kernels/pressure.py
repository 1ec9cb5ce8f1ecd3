"""Pressure where strands are too dense, by one-sided projection on the grid.

Density φ is relative to the greatest allowed, and f is the share of a cell that is outside of solids at the end of the
step. In a step of h with the momentum φ v that cells are going to have the density would be φ* = φ − h ∇·(φ v).
Pressure p >= 0 accelerates cells along −∇p, so that it becomes φ* + ∇²p (p here times h² over the cell's area); p is
the least with which that is nowhere more than f, and is 0 wherever there is room:

    Σ a_c a_d (p_c − p_d) >= e_c,    p_c >= 0,    one of both equal,    e = φ* − f,

with the sum over the faces of a cell, and a = √f, 0 in solids. A face next to a solid is open by a_c a_d, so that the
impulse on it is as much less as the strands are that it moves: were it whole, pressure would hurl strands upward along
walls, and a pile would circulate for good. For a p the problem is that of whole faces, with e over a. This linear
complementarity problem is solved by projected overrelaxation (Cryer 1971), which begins with the pressure of the step
before. Narain et al. 2009 push granular matter apart in the same way.

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

from ....jit import device, function, parallel, prange
from ....simd import (
    any_lane,
    broadcast,
    deinterleaved,
    half_width_pointer,
    interleaved,
    lane_count,
    load,
    pointer,
    store,
    where,
)
from ....solids.kernels.outside import any_depth
from .records import FULL, LANES, LOW, MASS, MOMENTUM, MOST, RATIO, SIZE, beside_across, beside_along

RELAXATION = np.float32(1.5)
GROUPS = 64
"""Of cells of a row at the most: bits of a word."""
DEEPEST = np.float32(0.75)
"""Cells from a surface to the middle of one in the solid from which on that is closed: a 32nd of it is open there. Were
it closed from half a cell on, strands could lie on a floor as dense as they like: a tuft sank by 3 %."""
ROUNDS = 12
"""Sweeps of a step: the pressure of the step before is nearly right already."""
HELD = np.float32(0.5)
"""Share of the pressure of the step before that is taken to be held by other forces wholly, whatever the grid sees of
them. With all of it pressure swings; with none, what the grid does not see has to be made up for by density."""
HASTE = np.float32(2)
"""Share of what there is too much of that pressure makes up for in a step, over the share of the density that it does
at the most: were it all, short steps would throw strands apart, which would go on until drag stops them. Of what there
is too little of pressure lets be filled up as much: were it all at once, cells that change would be too dense by the
mean, and a tuft would stand 10 % too low at 240 steps a second in place of 2."""
DENSEST = np.float32(4)
"""Densities, of those allowed, up to which that is a share of them: what is denser is led apart no faster."""


def work_shape(wide: int, high: int, deep: int) -> tuple[int, int, int, int]:
    """Shape of what `relax` works in, for a box of so many cells."""
    return 3, deep + 2, high + 1, 2 * (LANES + -(-wide // (2 * LANES)) * LANES)


@function
def relax(box, room, near, work, busy, pressure):
    """Sweep over the cells `ROUNDS` times, those of one colour after those of the other, as on a chessboard.

    near (cells along z, along y): whether strands are near that row of cells, in others pressure is 0; pressure
    (cells,): is changed. work (3, cells along z + 2, along y + 1, row): pressure times aperture, so that neighbours
    count by what is open of faces, excess and faces of `Room`, of each row those of even cells, and then those
    of odd ones, so that a vector has one colour; with a margin of zeros before each, which stays, so that no cell is a
    special case: the one after a row is that before the next. Cells without pressure beside others without stay so
    unless their excess is positive: they are left out, a vector or a multiple of it at once. busy (2, cells along z
    + 2, along y + 2) uint64: a bit for each such group of a row, whether an excess is positive, whether a pressure is.
    """
    wide, high, deep = box[SIZE], box[SIZE + 1], box[SIZE + 2]
    half = work.shape[3] // 2
    stride, layer = 2 * half, (high + 1) * 2 * half
    group = LANES * ((half - LANES) // LANES // GROUPS + 1)
    sizes = stride, layer, half, (deep + 2) * layer, group
    p = pointer(work)
    busy[...] = 0
    for o in range(deep):
        for n in range(high):
            at, row = (o + 1) * layer + (n + 1) * stride + LANES, (o * high + n) * wide
            if near[o, n]:
                positive, live = split_row(wide, row, at, sizes, room, pressure, work)
                busy[0, o + 1, n + 1], busy[1, o + 1, n + 1] = positive, live
            else:
                for k in range(0, half - LANES, LANES):
                    store(p, at + k, 0.0)
                    store(p, at + half + k, 0.0)
    for round in range(2 * ROUNDS):
        for o in range(deep):
            for n in range(high):
                if near[o, n]:
                    groups = busy[0, o + 1, n + 1] | groups_around(busy[1], o + 1, n + 1)
                    if groups != 0:
                        at = (o + 1) * layer + (n + 1) * stride + LANES
                        busy[1, o + 1, n + 1] = relax_row(p, at, sizes, (o + n + round) % 2, groups)
    for o in range(deep):
        for n in range(high):
            at, row = (o + 1) * layer + (n + 1) * stride + LANES, (o * high + n) * wide
            for i in range(0, wide, 2 * LANES):
                first, second = interleaved(load(p, at + i // 2), load(p, at + half + i // 2))
                keep(row + i, first, room, pressure)
                if i + LANES < wide:
                    keep(row + i + LANES, second, room, pressure)


@device
def keep(at, found, room, pressure):
    """Keep the pressure of a vector of cells, of which `relax` found the product with their apertures."""
    own = load(pointer(room.aperture), at)
    store(pointer(pressure), at, where(own > 0.0, found / own, 0.0))


@device
def split_row(wide, row, at, sizes, room, pressure, work):
    """Set a row of `relax`'s work, and return the groups of it whose excess is positive, and those that have
    pressure."""
    out, half, plane, group = half_width_pointer(work), sizes[2], sizes[3], sizes[4]
    positive = live = np.uint64(0)
    for i in range(0, wide, LANES):
        k = i // 2
        p = load(pointer(pressure), row + i) * load(pointer(room.aperture), row + i)
        e, f = load(pointer(room.excess), row + i), load(pointer(room.faces), row + i)
        positive |= bit_of(e, k // group)
        live |= bit_of(p, k // group)
        split(out, at + k, half, p)
        split(out, plane + at + k, half, e)
        split(out, 2 * plane + at + k, half, f)
    return positive, live


@device
def split(out, at, half, x):
    """Keep the numbers of even cells, and those of odd ones ``half`` a row further on."""
    even, odd = deinterleaved(x)
    store(out, at, even)
    store(out, at + half, odd)


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
def relax_row(p, at, sizes, odd, groups):
    """Relax a row's even or ``odd`` cells in these groups, and return which groups have pressure then."""
    stride, layer, half, plane, group = sizes
    found = np.uint64(0)
    for k in range(0, half - LANES, LANES):
        if groups >> np.uint64(k // group) & np.uint64(1) == 0:
            continue
        here, others = at + odd * half + k, at + (1 - odd) * half + k
        around = load(p, others - 1 + odd) + load(p, others + odd)
        around += load(p, here - stride) + load(p, here + stride)
        around += load(p, here - layer) + load(p, here + layer)
        own, share = load(p, here), load(p, 2 * plane + here)
        wanted = own + RELAXATION * ((load(p, plane + here) + around) * share - own)
        new = where(share > 0.0, max(wanted, 0.0), 0.0)
        store(p, here, new)
        found |= bit_of(max(new, load(p, others)), k // group)
    return found


@parallel
def find_room(box, cell, solids, along, near, open):
    """Set the share of each cell that is outside of ``solids``, ``open`` (cells,): of what trilinear weights reach, if
    the nearest surface were a plane across an axis; that times -1 of cells whose middle is deeper than `DEEPEST`.
    ``along``: (cells along x,) coordinates of their middles, metres, a multiple of `LANES`, as float32; ``near`` (cells
    along z, along y): whether strands are near that row of cells, others stay as they are."""
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
        store(out, i, where(s > 0.0, 1.0 - beyond, where(s > -DEEPEST, beyond, -beyond)))


@device
def find_excess(box, o, near, grid, room, pressure, numbers):
    """Set `Room.excess`, `Room.faces` and `Room.held` of layer o's rows that are ``near``, the last to 0 in others.
    ``pressure`` (cells,): of the step before; ``numbers`` (`NUMBERS`,)."""
    wide, high, deep = box[SIZE], box[SIZE + 1], box[SIZE + 2]
    held = pointer(room.held)
    for n in range(high):
        row = (o * high + n) * wide
        if not near[o, n]:
            for i in range(0, wide, LANES):
                store(held, row + i, broadcast(held, 0.0))
            continue
        up, far = beside_across(n, high, wide), beside_across(o, deep, wide * high)
        for i in range(0, wide, LANES):
            sides = beside_along(i, wide), up, far
            excess_of(row + i, sides, grid, room, pointer(pressure), numbers)


@device
def excess_of(at, sides, grid, room, pressure, numbers):
    """Set the numbers of a vector of cells, with `records`' ways to the cells on their ``sides``."""
    full, ratio, most = numbers[FULL], numbers[RATIO], numbers[MOST]
    apertures, cells, count = pointer(room.aperture), pointer(grid), grid.shape[1]
    flow, rise, width = face_sums(at, sides[0], cells, MOMENTUM * count + at, apertures, pressure)
    for_y = face_sums(at, sides[1], cells, (MOMENTUM + 1) * count + at, apertures, pressure)
    for_z = face_sums(at, sides[2], cells, (MOMENTUM + 2) * count + at, apertures, pressure)
    flow += for_y[0]
    flow += for_z[0]
    rise += for_y[1]
    rise += for_z[1]
    width += for_y[2]
    width += for_z[2]
    dense, free = load(cells, MASS * count + at) / full, load(pointer(room.open), at)
    own = load(apertures, at)
    inverse = where(own > 0.0, 1.0 / own, 0.0)
    more = dense - free
    haste = min(HASTE * most, np.float32(1))
    more = min(more * haste, most * min(max(dense, 1.0), DENSEST))
    store(pointer(room.held), at, HELD * load(pressure, at))
    store(pointer(room.excess), at, (more + ratio * flow / full) * inverse + HELD * rise)
    store(pointer(room.faces), at, where((own > 0.0) & (width > 0.0), own / width, 0.0))


@device
def face_sums(at, sides, cells, column, apertures, pressure):
    """Twice the momentum that comes in through the faces of cells along an axis, where no solid closes them; by how
    much their pressure is more than that of the neighbours there, times the apertures of these; and the sum of those.
    Beside the box all is open and empty.

    Momentum through a face is the mean of both cells' and, where the face opposite is closed, the other half of
    theirs; through the sides of the box it is the cell's own.
    """
    (before, after, second_before, second_after), (a, b, c, d) = sides
    none = broadcast(cells, 0.0)
    wide_before, wide_after = where(a, load(apertures, at + before), 1.0), where(b, load(apertures, at + after), 1.0)
    opens_before, opens_after = wide_before > 0.0, wide_after > 0.0
    shut_before = c & ~(load(apertures, at + second_before) > 0.0)
    shut_after = d & ~(load(apertures, at + second_after) > 0.0)
    own, past, next = load(cells, column), load(cells, column + before), load(cells, column + after)
    past, next = where(a, past, none), where(b, next, none)
    inward = past + own + where(shut_before, past, none) + where(a & ~opens_after, own, none)
    outward = own + next + where(b & ~opens_before, own, none) + where(shut_after, next, none)
    flow = where(opens_before, inward, none) - where(opens_after, outward, none)
    p = load(pressure, at)
    rise = wide_before * (p - where(a, load(pressure, at + before), none))
    rise += wide_after * (p - where(b, load(pressure, at + after), none))
    return flow, rise, wide_before + wide_after
