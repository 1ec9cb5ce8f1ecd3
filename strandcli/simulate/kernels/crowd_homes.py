"""Cells that solids close: what strands leave in them counts for the open cells next to them.

A strand that lies on a solid is between the middle of a closed cell and that of an open one. By trilinear weights alone
half of it or more would be of the closed cell, which has no pressure: it would be felt at a half, and moved by half of
the pressure. So metres and momentum of a closed cell are added to those of an open neighbour, its home, and strands
read the home's targets in its stead. What lies between both middles has no face that it could be pushed through, and
counts for the face on the home's other side.
"""

from __future__ import annotations

import numpy as np

from ...jit import device, function, parallel, prange
from .crowd_records import BETWEEN, CELL, MASS, MOMENTUM, PUSH, RATE, SIZE, TARGET

WAYS = 6
"""Neighbours of a cell: along x, y and z the one before and the one after. Homes are their numbers and 1, 0 where there
is none, and `WAYS` more where the neighbour is closed and has a home."""


@parallel
def find_homes(box, grid, open, homes):
    """Set ``homes`` (cells,) int8 of closed cells with strands: where an open neighbour is, the most open one."""
    wide, high, deep = box[SIZE], box[SIZE + 1], box[SIZE + 2]
    for o in prange(deep):
        for n in range(high):
            for i in range(wide):
                at = np.int64((o * high + n) * wide + i)
                homes[at] = 0
                if open[at] <= 0 and grid[at, MASS] > 0:
                    homes[at] = home_of(at, box, open)


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


@parallel
def find_far_homes(box, grid, open, homes):
    """Set ``homes`` of closed cells without an open neighbour, as in corners: the first closed one that has a home."""
    wide, high, deep = box[SIZE], box[SIZE + 1], box[SIZE + 2]
    for o in prange(deep):
        for n in range(high):
            for i in range(wide):
                at = np.int64((o * high + n) * wide + i)
                if homes[at] == 0 and open[at] <= 0 and grid[at, MASS] > 0:
                    homes[at] = far_home_of(at, box, homes)


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


@function
def bring_home(box, homes, grid, open):
    """Add closed cells' columns of ``grid`` and shares of ``open`` to those of their homes, far ones first."""
    for far in range(1, -1, -1):
        for at in range(len(homes)):
            if homes[at] > 0 and (homes[at] > WAYS) == (far == 1):
                home, axis, after = home_at(at, homes[at], box)
                for c in range(BETWEEN):
                    grid[home, c] += grid[at, c]
                    grid[at, c] = 0
                open[home] += open[at] if far == 1 else -open[at]
                open[at] = 0
                for other in range(3):
                    if other != axis or after:
                        grid[home, BETWEEN + other] += grid[at, BETWEEN + other]
                        grid[at, BETWEEN + other] = 0
    for at in range(len(homes)):
        if 0 < homes[at] <= WAYS:
            home, axis, after = home_at(at, homes[at], box)
            stride = at - home
            if not after and home >= stride:
                grid[home - stride, BETWEEN + axis] += grid[home, BETWEEN + axis]
                grid[home, BETWEEN + axis] = 0


@function
def read_home(box, homes, targets):
    """Set closed cells' columns of ``targets`` to those of their homes, far ones last."""
    for at in range(len(homes)):
        if 0 < homes[at] <= WAYS:
            home, axis, after = home_at(at, homes[at], box)
            stride = at - home
            if not after and home >= stride:
                targets[home, PUSH + axis] = targets[home - stride, PUSH + axis]
    for far in range(2):
        for at in range(len(homes)):
            if homes[at] > 0 and (homes[at] > WAYS) == (far == 1):
                home, axis, after = home_at(at, homes[at], box)
                for c in range(RATE, PUSH):
                    targets[at, c] = targets[home, c]
                for other in range(3):
                    if other != axis or after:
                        targets[at, PUSH + other] = targets[home, PUSH + other]


assert (MASS, MOMENTUM, RATE, TARGET, PUSH + 4) == (0, 1, 0, 1, CELL)
