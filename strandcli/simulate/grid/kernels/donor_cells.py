"""Cells that solids close: what strands leave in them counts for the open cells next to them.

Cells are closed whose middle is deeper than `pressure.DEEPEST`. A strand that lies on a solid or has sunk into it
may be between the middle of a closed cell and that of an open one. By trilinear weights alone
half of it or more would be of the closed cell, which has no pressure: it would be felt at a half, and moved by half of
the pressure. So metres and momentum of a closed cell are added to those of an open neighbour, its home, and strands
read the home's targets in its stead. What lies between both middles has no face that it could be pushed through, and
counts for the face on the home's other side.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, function
from ....simd import any_lane, broadcast, load, pointer, reduce_max
from .records import BETWEEN, CELL, LANES, MASS, MOMENTUM, PUSH, RATE, SIZE, TARGET

WAYS = 6
"""Neighbours of a cell: along x, y and z the one before and the one after. Homes are their numbers and 1, 0 where there
is none, and `WAYS` more where the neighbour is closed and has a home."""
COLUMNS = MASS, MOMENTUM, MOMENTUM + 1, MOMENTUM + 2
"""Of what is by trilinear weights."""
LEAST_ROOM = np.float32(0.5)
"""Share of a cell that counts as outside of solids at the least, where the greatest density is told."""


@function
def settle(box, near, grid, open, homes, closed):
    """Set ``homes`` (cells,) int8 of closed cells with strands, and add what those have of ``grid``, metres and all,
    and of ``open`` to that of their homes. Only rows of cells that are ``near`` (cells along z, along y) have strands.
    ``closed`` (2, cells + 1) int32: is set to the closed cells with strands, those with an open neighbour and others,
    after how many there are. Returns the most metres in a cell by what is open of it, of which `LEAST_ROOM` counts as
    open at the least."""
    find_homes(box, near, grid, open, homes, closed)
    for far in range(1, -1, -1):
        for at in closed[far, 1 : 1 + closed[far, 0]]:
            if homes[at] > 0:
                home, axis, after = home_at(np.int64(at), homes[at], box)
                for c in COLUMNS:
                    grid[c, home] += grid[c, at]
                    grid[c, at] = 0
                open[home] += open[at] if homes[at] > WAYS else -open[at]
                open[at] = 0
                for other in range(3):
                    if other != axis or after:
                        grid[BETWEEN + other, home] += grid[BETWEEN + other, at]
                        grid[BETWEEN + other, at] = 0
    for at in closed[0, 1 : 1 + closed[0, 0]]:
        home, beyond, axis = beyond_home(np.int64(at), homes[at], box)
        if beyond >= 0:
            grid[BETWEEN + axis, beyond] += grid[BETWEEN + axis, home]
            grid[BETWEEN + axis, home] = 0
    return greatest(box, near, grid, open)


@function
def read_home(box, homes, closed, targets):
    """Set closed cells' columns of ``targets`` to those of their homes, far ones last."""
    for at in closed[0, 1 : 1 + closed[0, 0]]:
        home, beyond, axis = beyond_home(np.int64(at), homes[at], box)
        if beyond >= 0:
            targets[home, PUSH + axis] = targets[beyond, PUSH + axis]
    for far in range(2):
        for at in closed[far, 1 : 1 + closed[far, 0]]:
            if homes[at] > 0:
                home, axis, after = home_at(np.int64(at), homes[at], box)
                for c in range(RATE, PUSH):
                    targets[at, c] = targets[home, c]
                for other in range(3):
                    if other != axis or after:
                        targets[at, PUSH + other] = targets[home, PUSH + other]


@device
def find_homes(box, near, grid, open, homes, closed):
    """Set the homes of closed cells with strands, and list these: where an open neighbour is, the most open one; of
    others, as in corners, the first closed one that has such a home."""
    wide, high = box[SIZE], box[SIZE + 1]
    metres, free = pointer(grid), pointer(open)
    homes[:] = 0
    closed[:, 0] = 0
    for row in range(high * box[SIZE + 2]):
        if not near[row // high, row % high]:
            continue
        for first in range(row * wide, (row + 1) * wide, LANES):
            if any_lane((load(metres, MASS * grid.shape[1] + first) > 0.0) & (load(free, first) <= 0.0)):
                for at in range(first, first + LANES):
                    if open[at] <= 0 and grid[MASS, at] > 0:
                        homes[at] = home_of(at, box, open)
                        far = np.int64(homes[at] == 0)
                        closed[far, 0] += 1
                        closed[far, closed[far, 0]] = at
    for at in closed[1, 1 : 1 + closed[1, 0]]:
        homes[at] = far_home_of(np.int64(at), box, homes)


@device
def greatest(box, near, grid, open):
    """The most metres in a cell by what is open of it."""
    wide, high = box[SIZE], box[SIZE + 1]
    metres, free = pointer(grid), pointer(open)
    most = broadcast(metres, 0.0)
    for row in range(high * box[SIZE + 2]):
        if near[row // high, row % high]:
            for at in range(row * wide, (row + 1) * wide, LANES):
                most = max(most, load(metres, MASS * grid.shape[1] + at) / max(load(free, at), LEAST_ROOM))
    return reduce_max(most)


@device
def home_of(at, box, open):
    """Number of the most open neighbour and 1; 0 where none is open."""
    found, most = 0, np.float32(0)
    stride = 1
    for axis in range(3):
        place = at // stride % box[SIZE + axis]
        if place > 0 and open[at - stride] > most:
            found, most = 2 * axis + 1, open[at - stride]
        if place < box[SIZE + axis] - 1 and open[at + stride] > most:
            found, most = 2 * axis + 2, open[at + stride]
        stride *= box[SIZE + axis]
    return found


@device
def far_home_of(at, box, homes):
    """Number of the first neighbour with a home next to it, and 1 and `WAYS`; 0 where there is none."""
    stride = 1
    for axis in range(3):
        place = at // stride % box[SIZE + axis]
        if place > 0 and 0 < homes[at - stride] <= WAYS:
            return WAYS + 2 * axis + 1
        if place < box[SIZE + axis] - 1 and 0 < homes[at + stride] <= WAYS:
            return WAYS + 2 * axis + 2
        stride *= box[SIZE + axis]
    return 0


@device
def home_at(at, home, box):
    """The cell that a home's number means, along which axis it lies, and whether it is the cell after."""
    way = (home - 1) % WAYS
    axis, after = way // 2, way % 2 == 1
    stride = np.int64(1)
    if axis > 0:
        stride *= box[SIZE]
    if axis > 1:
        stride *= box[SIZE + 1]
    return at + stride if after else at - stride, axis, after


@device
def beyond_home(at, number, box):
    """The home of a closed cell, and where that lies before it the cell on the home's other side, whose face what lies
    between both middles counts for; -1 where there is none. And along which axis."""
    home, axis, after = home_at(at, number, box)
    beyond = home - (at - home)
    return home, np.int64(-1) if after else beyond, axis


assert (MASS, MOMENTUM, RATE, TARGET, PUSH + 4) == (0, 1, 0, 1, CELL)
