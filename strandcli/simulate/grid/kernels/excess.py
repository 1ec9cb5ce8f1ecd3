"""What pressure has to make up for in each cell, and the faces that it acts on: see `pressure`."""

from __future__ import annotations

import numpy as np

from ....jit import device
from ....simd import broadcast, load, pointer, store, where
from .records import FULL, LANES, MASS, MOMENTUM, MOST, RATIO, SIZE
from .rows import beside_across, beside_along

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
    """Set the numbers of a vector of cells, with `rows`' ways to the cells on their ``sides``."""
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
