"""Pressure where strands are too dense, by one-sided projection on the grid (`docs/solvers.md`).

A face next to a solid is open by a_c a_d with a = √f, so that the impulse on it is as much less as the strands are that
it moves: were it whole, pressure would hurl strands upward along walls. For a p the problem is that of whole faces,
with e = φ* − f over a.

Loads. The velocity in φ* has what all other forces changed velocities by in the last step: of a pile at rest they undo
what pressure does, and so it is found anew with φ = f, whatever the load and the step. The grid sees less of them than
there is, near surfaces and where cells are few. So only 1 − `HELD` of what they undo is seen so, and for the rest the
pressure of the step before is taken as it is.

Bounds (`limit`). Where strands are far too dense beside room, the few at the edge would be thrown by dozens of cells.
On a face pressure may stop what comes against it and what falls against it, hold what it did before, and hasten what
it leads apart by a, or bring it to the speed w:

    p_c − p_d <= m (max(a + max(−v, 0), w − v) + max(−g, 0)) + HELD max(p'_c − p'_d, 0),    a = 2 s², w = s

of the metres m that the impulse on the face moves, their velocity v from c to d, gravity's change g of it, all in cells
a step, the pressure p' of the step before, and the share s of the density that it makes up for in the step at the most.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, function, parallel, prange
from ....simd import any_lane, broadcast, lane_count, load, pointer, sqrt, store, where
from ....solids.kernels.outside import any_depth
from .records import BETWEEN, FALL, FULL, LANES, LOW, MASS, MOMENTUM, MOST, RATIO, SIZE, SPEED, beside

RELAXATION = np.float32(1.5)
ROUNDS = 12
"""Sweeps of a step: the pressure of the step before is nearly right already."""
LIMITS = 16
"""Sweeps of `limit` at the most."""
DEEPEST = np.float32(0.95)
"""Cells from a surface to the middle of one in the solid from which on that is closed."""
HELD = np.float32(0.5)
"""Share of the pressure of the step before that other forces are taken to carry; with all it swings."""
HASTE = np.float32(2)
"""Share that pressure makes up for in a step, over that of the density at the most: all would throw strands."""
DENSEST = np.float32(4)
"""Densities, of those allowed, up to which that is a share of them: what is denser is led apart no faster."""
HASTENED, LED = np.float32(2), np.float32(1)
"""a over s², and w over s. With w alone strands that move on together could not be stopped."""
BETWEEN_ONLY = np.float32(0.5)
"""Share of the impulse on a face for what lies between middles: with none, strands gather in every other cell."""
WIDELY = np.float32(0.5) * (1 - BETWEEN_ONLY)
"""And the share that each of the cells gets, by trilinear weights."""
SLIVER = np.float32(1e-4)
"""Share of a full cell about a face below which the impulse on it, of rounding, is not all handed on."""


def work_shape(wide: int, high: int, deep: int) -> tuple[int, int, int]:
    """Shape of what `relax` works in, for a box of so many cells."""
    return deep + 2, high + 2, wide + LANES


@device
def relax(box, room, near, work, live, pressure):
    """Sweep over the cells `ROUNDS` times, those of one colour after those of the other, as on a chessboard.

    near (cells along z, along y): whether strands are near that row of cells, in the rest pressure is 0; pressure
    (cells,): is changed. work (`work_shape`): pressure times aperture, with a margin of zeros, so that no cell is a
    special case: the one after a row is that before the next. Rows without pressure beside rows without are left out
    unless their excess is positive: ``live`` (2, cells along z + 2, along y + 2) tells of each whether an excess is
    positive, and a pressure."""
    wide, high, rows = box[SIZE], box[SIZE + 1], box[SIZE + 1] * box[SIZE + 2]
    stride, p = wide + LANES, pointer(work)
    layer = (high + 2) * stride
    live[...] = False
    for row in range(rows):
        o, n = row // high + 1, row % high + 1
        at, positive, presses = o * layer + n * stride + LANES, False, False
        for i in range(0, wide, LANES):
            own = load(pointer(pressure), row * wide + i) * load(pointer(room.aperture), row * wide + i)
            store(p, at + i, own)
            presses |= any_lane(own > 0.0)
            positive |= any_lane(load(pointer(room.excess), row * wide + i) > 0.0)
        live[0, o, n], live[1, o, n] = positive and near[o - 1, n - 1], presses
    for round in range(2 * ROUNDS):
        for row in range(rows):
            o, n = row // high + 1, row % high + 1
            around = live[1, o, n - 1] or live[1, o, n + 1] or live[1, o - 1, n] or live[1, o + 1, n]
            if near[o - 1, n - 1] and (live[0, o, n] or live[1, o, n] or around):
                at = o * layer + n * stride + LANES
                live[1, o, n] = relax_row(p, at, (stride, layer), row * wide, wide, (o + n + round) % 2, room)
    for row in range(rows):
        at = (row // high + 1) * layer + (row % high + 1) * stride + LANES
        for i in range(0, wide, LANES):
            own = load(pointer(room.aperture), row * wide + i)
            store(pointer(pressure), row * wide + i, where(own > 0.0, load(p, at + i) / own, 0.0))


COLOURS = np.tile(np.array([0, 1], np.float32), LANES)
"""1 for odd cells."""


@device
def relax_row(p, at, strides, row, wide, odd, room):
    """Relax a row's even or ``odd`` cells, and return whether some cell of it has pressure then."""
    stride, layer = strides
    mine, found = load(pointer(COLOURS), 1 - odd) > 0.0, False
    for i in range(0, wide, LANES):
        here = at + i
        around = load(p, here - 1) + load(p, here + 1)
        around += load(p, here - stride) + load(p, here + stride)
        around += load(p, here - layer) + load(p, here + layer)
        own, share = load(p, here), load(pointer(room.faces), row + i)
        wanted = own + RELAXATION * ((load(pointer(room.excess), row + i) + around) * share - own)
        new = where(mine, where(share > 0.0, max(wanted, 0.0), 0.0), own)
        store(p, here, new)
        found |= any_lane(new > 0.0)
    return found


@parallel
def find_room(box, cell, solids, along, near, open, aperture):
    """Set the share of each cell that is outside of ``solids``, ``open`` (cells,): of what trilinear weights reach, if
    the nearest surface were a plane across an axis, 0 of cells whose middle is deeper than `DEEPEST`; and its root.
    ``along``: (cells along x,) coordinates of their middles, metres, a multiple of `LANES`, as float32; ``near`` (cells
    along z, along y): whether strands are near that row of cells, the rest stay as they are."""
    wide, high = box[SIZE], box[SIZE + 1]
    x = pointer(along)
    for o in prange(box[SIZE + 2]):
        z = np.float32(cell * (o + box[LOW + 2] + 0.5))
        for n in range(high):
            if not near[o, n]:
                continue
            y, row = np.float32(cell * (n + box[LOW + 1] + 0.5)), (o * high + n) * wide
            for i in range(0, wide, lane_count(x)):
                here = load(x, i)
                s = any_depth(solids, here, broadcast(x, y), broadcast(x, z)) * -np.float32(1 / cell)
                beyond = max(1.0 - abs(s), 0.0)
                beyond = 0.5 * beyond * beyond
                share = where(s > 0.0, 1.0 - beyond, where(s > -DEEPEST, beyond, 0.0))
                store(pointer(open), row + i, share)
                store(pointer(aperture), row + i, sqrt(share))


@device
def find_excess(box, o, near, grid, room, pressure, numbers):
    """Set `Room.excess`, `Room.faces` and `Room.carried` of layer o's rows that are ``near``, the last to 0 in the
    rest. ``pressure`` (cells,): of the step before; ``numbers`` (`NUMBERS`,)."""
    wide, high, deep = box[SIZE], box[SIZE + 1], box[SIZE + 2]
    carried = pointer(room.carried)
    for row in range(o * high, (o + 1) * high):
        for i in range(0, wide, LANES):
            if near[o, row % high]:
                excess_of(row * wide + i, beside(row, i, wide, high, deep), grid, room, pointer(pressure), numbers)
            else:
                store(carried, row * wide + i, broadcast(carried, 0.0))


@device
def excess_of(at, sides, grid, room, pressure, numbers):
    """Set the numbers of a vector of cells, with `records`' steps to the cells on their ``sides``."""
    full, ratio, most = numbers[FULL], numbers[RATIO], numbers[MOST]
    apertures, cells, count = pointer(room.aperture), pointer(grid), grid.shape[1]
    column = MOMENTUM * count + at
    flow, rise, width = face_sums(at, sides[0], cells, column, apertures, pressure)
    for_y = face_sums(at, sides[1], cells, column + count, apertures, pressure)
    for_z = face_sums(at, sides[2], cells, column + 2 * count, apertures, pressure)
    flow, rise, width = flow + for_y[0] + for_z[0], rise + for_y[1] + for_z[1], width + for_y[2] + for_z[2]
    dense, own = load(cells, MASS * count + at) / full, load(apertures, at)
    inverse = where(own > 0.0, 1.0 / own, 0.0)
    haste = min(HASTE * most, np.float32(1))
    more = (dense - load(pointer(room.open), at)) * haste
    more = min(more, most * min(max(dense, 1.0), DENSEST))
    store(pointer(room.carried), at, HELD * load(pressure, at))
    store(pointer(room.excess), at, (more + ratio * flow / full) * inverse + HELD * rise)
    store(pointer(room.faces), at, where((own > 0.0) & (width > 0.0), own / width, 0.0))


@device
def face_sums(at, sides, cells, column, apertures, pressure):
    """Twice the momentum that comes in through the faces of cells along an axis, where no solid closes them; by how
    much their pressure is more than that of the neighbours there, times the apertures of these; and the sum of those.
    Beside the box all is open and empty. Momentum through a face is the mean of both cells' and, where the face
    opposite is closed, the other half of theirs: else nothing would hold that."""
    before, after, (a, b, c, d) = sides
    none, own, p = broadcast(cells, 0.0), load(cells, column), load(pressure, at)
    wide_before, wide_after = where(a, load(apertures, at + before), 1.0), where(b, load(apertures, at + after), 1.0)
    past, next = where(a, load(cells, column + before), none), where(b, load(cells, column + after), none)
    inward = past + own + where(c & ~(load(apertures, at + 2 * before) > 0.0), past, none)
    inward += where(a & ~(wide_after > 0.0), own, none)
    outward = own + next + where(d & ~(load(apertures, at + 2 * after) > 0.0), next, none)
    outward += where(b & ~(wide_before > 0.0), own, none)
    inward, outward = where(wide_before > 0.0, inward, none), where(wide_after > 0.0, outward, none)
    rise = wide_before * (p - where(a, load(pressure, at + before), none))
    rise += wide_after * (p - where(b, load(pressure, at + after), none))
    return inward - outward, rise, wide_before + wide_after


@device
def moved(m, m_next, between, full):
    """Metres that the impulse on the face of two cells moves, at least a `SLIVER`."""
    return max(WIDELY * (m + m_next) + BETWEEN_ONLY * between, SLIVER * full)


@function
def limit(box, grid, room, numbers, live, pressure):
    """Lower the ``pressure`` (cells,) where it is more than it may be, in rows that are ``live`` (cells along z + 2,
    along y + 2)."""
    wide, high, deep, p = box[SIZE], box[SIZE + 1], box[SIZE + 2], pointer(pressure)
    rows = high * deep
    for sweep in range(LIMITS):
        lowered = False
        for k in range(rows):
            row = rows - 1 - k if sweep % 2 == 1 else k
            if not live[row // high + 1, row % high + 1]:
                continue
            for i in range(0, wide, LANES):
                at = row * wide + i
                own = load(p, at)
                if any_lane(own > 0.0):
                    sides, most = beside(row, i, wide, high, deep), own
                    for axis in range(3):
                        most = min(most, most_along(at, sides[axis], axis, grid, room, numbers, p))
                    lowered |= any_lane(most < own)
                    store(p, at, most)
        if not lowered:
            break


@device
def most_along(at, sides, axis, grid, room, numbers, p):
    """The greatest pressure of a vector of cells by those of the neighbours along an axis."""
    before, after, (a, b, _, _) = sides
    cells, between = pointer(grid), (BETWEEN + axis) * grid.shape[1] + at
    own, fall = load(p, at), numbers[FALL + axis]
    past = most_by(at, before, axis, load(cells, between + before), (1.0, fall), grid, room, numbers, p)
    next = most_by(at, after, axis, load(cells, between), (-1.0, -fall), grid, room, numbers, p)
    return min(where(a, past, own), where(b, next, own))


@device
def most_by(at, step, axis, between, signs, grid, room, numbers, p):
    """The same by that of the neighbours a ``step`` on. ``signs``: −1 where that is forward, else 1, and gravity
    against it."""
    cells, count, apertures, full = pointer(grid), grid.shape[1], pointer(room.aperture), numbers[FULL]
    m, m_next = load(cells, MASS * count + at), load(cells, MASS * count + at + step)
    column = (MOMENTUM + axis) * count + at
    against = (load(cells, column) + load(cells, column + step)) / max(m + m_next, SLIVER * full)
    against = against * (signs[0] / numbers[SPEED])
    share = numbers[MOST]
    apart = HASTENED * share * share
    led = max(apart + max(against, 0.0), LED * share + against) + max(signs[1], np.float32(0))
    own, wide = load(apertures, at), load(apertures, at + step)
    face = full * own * wide
    carried = max(load(pointer(room.carried), at) - load(pointer(room.carried), at + step), 0.0)
    most = load(p, at + step) + carried + moved(m, m_next, between, full) / max(face, SLIVER * full) * led
    return where(wide > 0.0, most, load(p, at))
