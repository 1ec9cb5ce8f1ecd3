"""Targets of cells: what the strands in them are to do in a step, for `forces` to hand to strands."""

from __future__ import annotations

import numpy as np

from ....jit import device
from ....simd import any_lane, broadcast, load, pointer, store, store3, store_records, where
from .limit import BETWEEN_ONLY, SLIVER, WIDELY
from .records import (
    BETWEEN,
    CELL,
    CHANGE,
    FULL,
    LANES,
    LOST,
    MASS,
    MOMENTUM,
    SIZE,
    SPEED,
    WAY,
    beside_across,
    beside_along,
)
from .shelter import left_at, main_axis

EMPTY = np.float32(1e-30)
"""Metres in a cell up to which it is empty."""


@device
def find_targets(box, o, near, grid, room, numbers, pressure, targets, others):
    """Set the targets of layer o. A cell that no sample reaches has none. Set the layer's row of ``others`` (cells
    along z, 4 `LANES`), which tells what momentum strands get from others than strands: the metres of its cells times
    the share of the wind that they do not get, less than 0, and pressure against solids (3)."""
    wide, high, deep = box[SIZE], box[SIZE + 1], box[SIZE + 2]
    main, cells = main_axis(numbers[WAY : WAY + 3]), pointer(grid)
    less = broadcast(cells, 0.0)
    x, y, z = less, less, less
    for n in range(high):
        if not near[o, n]:
            continue
        up, far = beside_across(n, high, wide), beside_across(o, deep, wide * high)
        for i in range(0, wide, LANES):
            sides = beside_along(i, wide), up, far
            at = (o * high + n) * wide + i
            if any_lane(load(pointer(pressure), at) > 0.0):
                u, v, w = pushed_back(at, sides, pointer(room.aperture), pointer(pressure))
                x, y, z = x + u, y + v, z + w
            if any_lane(counted(at, grid) > 0.0):
                found = targets_of(at, sides, grid, room.aperture, numbers, pointer(pressure))
                if len(room.left) > 0:
                    # what strands that have so much of the wind left do not take of it
                    left = left_at(box, main, (o, n, i), room.left)
                    lost = left - 1.0
                    rate, u, v, w, near_x, near_y, near_z = found
                    u, v, w = u + lost * numbers[CHANGE], v + lost * numbers[CHANGE + 1], w + lost * numbers[CHANGE + 2]
                    found = rate, u, v, w, near_x, near_y, near_z
                    less += load(cells, MASS * grid.shape[1] + at) * (left - 1.0)
                keep(at, grid, found, targets)
            else:
                clear(at, targets)
    store(pointer(others), o * 4 * LANES, less)
    store3(pointer(others), (o * 4 + 1) * LANES, LANES, x, y, z)


@device
def counted(at, grid):
    """Above 0 in cells for which a sample counts."""
    cells, count = pointer(grid), grid.shape[1]
    x, y, z = load_three(cells, BETWEEN, count, at)
    return max(max(max(x, y), z), load(cells, MASS * count + at))


@device
def clear(at, targets):
    """Set the targets of a vector of cells to none."""
    out = pointer(targets)
    for c in range(CELL):
        store(out, CELL * at + c * LANES, 0.0)


@device
def keep(at, grid, found, targets):
    """Set the targets of a vector of cells, of which some count for no sample."""
    counts = counted(at, grid) > 0.0
    a, b, c, d, e, f, g = found
    kept = (
        where(counts, a, 0.0), where(counts, b, 0.0), where(counts, c, 0.0), where(counts, d, 0.0),
        where(counts, e, 0.0), where(counts, f, 0.0), where(counts, g, 0.0), broadcast(a, 0.0),
    )  # fmt: skip
    store_records(pointer(targets), CELL * at, kept)


@device
def targets_of(at, sides, grid, apertures, numbers, pressure):
    """The columns of the targets of a vector of cells, with `records`' ways to the cells on their ``sides``."""
    cells, count, full = pointer(grid), grid.shape[1], numbers[FULL]
    m = load(cells, MASS * count + at)
    rate = numbers[LOST] * min(m / full, 1.0)
    f = rate / max(m, EMPTY)
    u, v, w = load_three(cells, MOMENTUM, count, at)
    between, all = BETWEEN * count + at, (at, numbers, cells, pressure, pointer(apertures))
    near_x, wide_x = pushes(all, sides[0], between)
    near_y, wide_y = pushes(all, sides[1], between + count)
    near_z, wide_z = pushes(all, sides[2], between + 2 * count)
    return rate, f * u + wide_x, f * v + wide_y, f * w + wide_z, near_x, near_y, near_z


@device
def load_three(cells, column, count, at):
    """Vectors of three columns."""
    at += column * count
    return load(cells, at), load(cells, at + count), load(cells, at + 2 * count)


@device
def pushes(all, sides, between):
    """Change of velocity, m/s, by the pressure on the faces along an axis: of what lies between the middles of cells
    and of the next ones, and of the cells. ``between``: place of the first one's column along the axis."""
    at, numbers, cells, pressure, apertures = all
    (before, after, _, _), (a, b, _, _) = sides
    none = broadcast(cells, 0.0)
    m, p, own = load(cells, at), load(pressure, at), load(apertures, at)
    least, push = SLIVER * numbers[FULL], numbers[SPEED] * numbers[FULL]
    next = pushed(p, load(pressure, at + after), m, load(cells, at + after), load(cells, between), least)
    past = pushed(load(pressure, at + before), p, load(cells, at + before), m, load(cells, between + before), least)
    next = where(b, own * load(apertures, at + after) * next, none)
    past = where(a, own * load(apertures, at + before) * past, none)
    return push * BETWEEN_ONLY * next, push * WIDELY * (next + past)


@device
def pushed(p, next, m, m_next, between, least):
    """Change of velocity by the pressure on the faces to the next cells, in cells a step for each metre in a cell."""
    return (p - next) / max(WIDELY * (m + m_next) + BETWEEN_ONLY * between, least)


@device
def pushed_back(at, sides, apertures, pressure):
    """What solids push back: the pressure of a vector of cells on what solids close of their faces, along x, y and z.
    It is what remains of the sum over all faces, of which each has the difference of two cells as far as it is open."""
    p = load(pressure, at) * load(apertures, at)
    x, y = back_along(at, sides[0], apertures, p), back_along(at, sides[1], apertures, p)
    return x, y, back_along(at, sides[2], apertures, p)


@device
def back_along(at, sides, apertures, p):
    """The same along an axis. Beside the box there is no pressure."""
    (before, after, _, _), (a, b, _, _) = sides
    past, next = where(a, load(apertures, at + before), 1.0), where(b, load(apertures, at + after), 1.0)
    return p * (next - past)


assert MASS == 0
