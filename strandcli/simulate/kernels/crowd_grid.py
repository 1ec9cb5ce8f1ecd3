"""Metres and momentum of strands in the cells of a grid.

A segment is spread, and not its particles, so that gaps between particles do not show: it is sampled at points no more
than a cell apart, each of which counts for its share of the segment and goes to the eight cells around it by trilinear
weights. The velocity of a sample is interpolated between those of the segment's ends, as contact will change them.
"""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import device, parallel, prange
from .crowd_records import BOX, CELL, FIRST, LAST, LOW, OFFSET, SHARE, SIZE, VELOCITY
from .rod_scratch import PACK


@parallel
def find_boxes(positions, cell, parts, scratch, boxes):
    """Set the lowest and the greatest coordinates in cells, ``boxes`` (parts, 6) float64, of the strands of each of
    ``parts``; NaN where a coordinate is not finite. ``positions`` (blocks, N + 2, 3 W)."""
    for part in prange(len(parts)):
        for axis in range(3):
            low, high = extent(positions, parts[part, FIRST] * PACK, parts[part, LAST] * PACK, axis, scratch.rows[part])
            boxes[part, axis] = low / cell
            boxes[part, 3 + axis] = high / cell


@device
def extent(positions, first, last, axis, scratch):
    """Least and greatest coordinate along an axis of the particles of strands; NaN where one is not finite."""
    low, high, total = scratch[0], scratch[1], scratch[2]
    low[...], high[...], total[...] = np.inf, -np.inf, 0
    flat = positions.reshape(-1)
    rows = positions.shape[1]
    for strand in range(first, last, PACK):
        at = strand // W * rows * 3 * W + axis * W + strand % W
        for row in range(1, rows):
            fold(flat[at + row * 3 * W : at + row * 3 * W + PACK], low, high, total)
    for k in range(1, PACK):
        low[0], high[0] = min(low[0], low[k]), max(high[0], high[k])
        total[0] += total[k]
    return low[0] + total[0], high[0] + total[0]


@device
def fold(values, low, high, total):
    """Take values into the least, the greatest, and what is not 0 where some value was not finite, lane by lane."""
    for k in range(PACK):
        x = np.float32(values[k])
        low[k] = x if x < low[k] else low[k]
        high[k] = x if x > high[k] else high[k]
        total[k] += x - x


@parallel
def deposit(moving, lattice, parts, boxes, memory, scratch):
    """Set each part's cells, in a box of its own: ``boxes`` (parts, `BOX`) int64, ``memory`` (cells of all, `CELL`)."""
    for part in prange(len(parts)):
        box = boxes[part]
        grid = memory[box[OFFSET] : box[OFFSET] + box[SIZE] * box[SIZE + 1] * box[SIZE + 2]]
        grid[...] = 0
        for pack in range(parts[part, FIRST], parts[part, LAST]):
            deposit_pack(
                moving, lattice, pack, box, lattice.origins[part], grid.reshape(-1), scratch.rows[part],
                scratch.cells[part],
            )  # fmt: skip


@device
def deposit_pack(moving, lattice, pack, box, origins, grid, rows, cells):
    """Add the metres and the momentum of a pack of strands to the cells of a box, ``grid`` (cells `CELL`,)."""
    wide = box[SIZE] * CELL
    layer = wide * box[SIZE + 1]
    metres = moving.metres[pack]
    for j in range(moving.velocity.shape[1]):
        share = np.float32(moving.segments[j] * lattice.share)
        for t in lattice.samples:
            locate(moving, lattice, pack, j, t, box, origins, rows, cells)
            for k in range(PACK):
                m = metres[k] * share
                u, v, w = rows[VELOCITY, k], rows[VELOCITY + 1, k], rows[VELOCITY + 2, k]
                a, c, d = rows[SHARE, k], rows[SHARE + 1, k], rows[SHARE + 2, k]
                at = np.uint64(cells[k])
                e, f = m - m * d, m * d
                add_row(grid, at, a, e - e * c, u, v, w)
                add_row(grid, at + np.uint64(wide), a, e * c, u, v, w)
                add_row(grid, at + np.uint64(layer), a, f - f * c, u, v, w)
                add_row(grid, at + np.uint64(layer + wide), a, f * c, u, v, w)


@device
def locate(moving, lattice, pack, j, t, box, origins, rows, cells):
    """Set the rows of scratch for a sample at the share t of segment j of a pack's strands: cells, shares, velocity."""
    n = moving.velocity.shape[1]
    row = 3 * W
    at = pack * PACK // W * (n + 2) * row + (j + 1) * row + pack * PACK % W
    positions = moving.positions.reshape(-1)
    sides = 1, box[SIZE], box[SIZE] * box[SIZE + 1]
    cells[...] = 0
    for c in range(3):
        here = positions[at + c * W : at + c * W + PACK]
        there = positions[at + row + c * W : at + row + c * W + PACK]
        origin = origins[c]
        shares(here, there, t, origin, lattice.inverse, box[SIZE + c] - 2, sides[c], rows[SHARE + c], cells)
        lanes = slice(c * PACK, c * PACK + PACK)
        push = moving.push[min(pack, len(moving.push) - 1)]
        if j > 0:
            begin, pushed = moving.velocity[pack, j - 1, lanes], push[j - 1, lanes]
            velocities(
                begin, pushed, moving.velocity[pack, j, lanes], push[j, lanes], t, lattice.pressed, rows[VELOCITY + c]
            )
        else:
            begin, end = moving.roots[pack, lanes], moving.velocity[pack, j, lanes]
            velocities_at_root(begin, end, push[j, lanes], t, lattice.pressed, rows[VELOCITY + c])


@device
def shares(here, there, t, origin, inverse, most, side, share, cells):
    """Along an axis, set the share of the cell beyond each sample, and add the place of the cell before it to
    ``cells``. ``origin``: middle of the box's first cell, metres; ``side``: distance of neighbours in the memory."""
    zero = np.float32(0)
    last = np.float32(most)
    for k in range(PACK):
        x = here[k]
        f = np.float32(x + t * (there[k] - x) - origin) * inverse
        i = min(max(np.floor(f), zero), last)
        share[k] = f - i
        cells[k] += np.int64(np.int32(i)) * side * CELL


@device
def velocities(begin, pushed, end, push, t, pressed, out):
    """Set velocities interpolated between the ends of segments, along an axis."""
    for k in range(PACK):
        u = begin[k] + pressed * pushed[k]
        out[k] = u + t * (end[k] + pressed * push[k] - u)


@device
def velocities_at_root(begin, end, push, t, pressed, out):
    """Set velocities interpolated between roots and first particles, along an axis."""
    for k in range(PACK):
        u = begin[k]
        out[k] = u + t * (end[k] + pressed * push[k] - u)


@device
def add_row(grid, at, a, m, u, v, w):
    """Add m metres to two neighbouring cells, the share ``a`` to the second, with a velocity (u, v, w)."""
    f = m - m * a
    add_cell(grid, at, f, f * u, f * v, f * w)
    f = m * a
    add_cell(grid, at + np.uint64(CELL), f, f * u, f * v, f * w)


@device
def add_cell(grid, at, m, x, y, z):
    """Add to the four columns of a cell."""
    a, b, c, d = grid[at], grid[at + np.uint64(1)], grid[at + np.uint64(2)], grid[at + np.uint64(3)]
    grid[at] = a + m
    grid[at + np.uint64(1)] = b + x
    grid[at + np.uint64(2)] = c + y
    grid[at + np.uint64(3)] = d + z


@parallel
def merge(boxes, memory, grid):
    """Add the parts' cells up, part by part. The last of ``boxes`` is that of all strands; ``grid`` (its cells, `CELL`)
    is set."""
    last = len(boxes) - 1
    whole = boxes[last]
    wide, high = whole[SIZE], whole[SIZE + 1]
    for o in prange(whole[SIZE + 2]):
        grid[o * wide * high : (o + 1) * wide * high] = 0
        for part in range(last):
            add_layer(boxes[part], whole, o, memory, grid)


@device
def add_layer(box, whole, o, memory, grid):
    """Add a part's cells of one layer of the whole box to it."""
    inner = o + whole[LOW + 2] - box[LOW + 2]
    if inner < 0 or inner >= box[SIZE + 2]:
        return
    for n in range(box[SIZE + 1]):
        at = ((o * whole[SIZE + 1] + n + box[LOW + 1] - whole[LOW + 1]) * whole[SIZE]) + box[LOW] - whole[LOW]
        source = box[OFFSET] + (inner * box[SIZE + 1] + n) * box[SIZE]
        for i in range(box[SIZE]):
            for c in range(CELL):
                grid[at + i, c] += memory[source + i, c]


assert OFFSET + 1 == BOX
