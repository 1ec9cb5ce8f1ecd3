"""Metres and momentum of strands in the cells of a grid.

Segments are spread, and not particles, so that gaps between particles do not show: strands are sampled at points no
more than a cell apart, each of which counts for its share of them and goes to the eight cells around it by trilinear
weights. Where segments are longer than cells, samples lie on them; where they are shorter, one sample stands for
several. Its place and velocity are means over the particles that it stands between, the velocity as contact will change
it.
"""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import device, parallel, prange
from ...simd import (
    any_lane,
    broadcast,
    floor,
    half_width_pointer,
    lane_count,
    load,
    pointer,
    reduce_max,
    store,
    where,
    with_lane,
)
from .crowd_records import BELOW, BETWEEN, BOX, CELL, FIRST, LAST, LOW, OFFSET, SHARE, SIZE, VELOCITY
from .rod_scratch import PACK

ROW = 3 * W
"""Numbers of a row of positions."""
OWN = np.zeros((3, CELL), np.float32)
"""1 in the column of what lies between middles along each axis."""
OWN[np.arange(3), BETWEEN + np.arange(3)] = 1


@parallel
def find_boxes(positions, cell, parts, boxes):
    """Set the lowest and the greatest coordinates in cells, ``boxes`` (parts, 6) float64, of the strands of each of
    ``parts``; NaN where a coordinate is not finite. ``positions`` (blocks, N + 2, 3 W)."""
    for part in prange(len(parts)):
        for axis in range(3):
            low, high = extent(positions, parts[part, FIRST] * PACK, parts[part, LAST] * PACK, axis)
            boxes[part, axis] = low / cell
            boxes[part, 3 + axis] = high / cell


@device
def extent(positions, first, last, axis):
    """Least and greatest coordinate along an axis of the particles of strands; NaN where one is not finite."""
    x = pointer(positions)
    rows = positions.shape[1]
    high = load(x, first // W * rows * ROW + ROW + axis * W + first % W)
    low = -high
    wrong = high - high
    for strand in range(first, last, lane_count(x)):
        at = strand // W * rows * ROW + axis * W + strand % W
        for row in range(1, rows):
            value = load(x, at + row * ROW)
            high, low = max(high, value), max(low, -value)
            wrong += value - value
    if any_lane(wrong != 0.0):
        return math.nan, math.nan
    return -reduce_max(low), reduce_max(high)


@parallel
def deposit(moving, lattice, parts, boxes, memory, scratch):
    """Set each part's cells, in a box of its own: ``boxes`` (parts, `BOX`) int64, ``memory`` (cells of all, `CELL`)."""
    for part in prange(len(parts)):
        box = boxes[part]
        grid = memory[box[OFFSET] : box[OFFSET] + box[SIZE] * box[SIZE + 1] * box[SIZE + 2]]
        grid[...] = 0
        for pack in range(parts[part, FIRST], parts[part, LAST]):
            deposit_pack(moving, lattice, pack, box, lattice.origins[part], grid.reshape(-1), scratch[part])


@device
def deposit_pack(moving, lattice, pack, box, origins, grid, rows):
    """Add the metres and the momentum of a pack of strands to the cells of a box, ``grid`` (cells `CELL`,)."""
    wide = box[SIZE] * CELL
    layer = wide * box[SIZE + 1]
    metres, cells = moving.metres[pack], half_width_pointer(grid)
    for sample in range(len(lattice.first)):
        share = np.float32(lattice.mass[sample])
        locate(moving, lattice, pack, sample, box, origins, rows)
        for k in range(PACK):
            u, v, w = three(rows, VELOCITY, k)
            each = with_lane(with_lane(with_lane(broadcast(cells, 1.0), 1, u), 2, v), 3, w)
            a, c, d = three(rows, SHARE, k)
            x, x_next = weights_along(cells, 0, a)
            y, y_next = weights_along(cells, 1, c)
            z, z_next = weights_along(cells, 2, d)
            m = metres[k] * share
            x *= m * each
            x_next *= m * each
            at = cell_of(rows, k, wide, layer)
            add_row(cells, at, x, x_next, y * z)
            add_row(cells, at + np.uint64(wide), x, x_next, y_next * z)
            add_row(cells, at + np.uint64(layer), x, x_next, y * z_next)
            add_row(cells, at + np.uint64(layer + wide), x, x_next, y_next * z_next)


@device
def weights_along(cells, axis, a):
    """The factors along an axis of the weights with which a sample counts in each column of a cell, and of the next
    one, to whose middle it has gone the share ``a`` of the way. What lies between middles counts for the first."""
    own = load(half_width_pointer(OWN), CELL * axis) > 0.0
    return where(own, 1.0, broadcast(cells, np.float32(1) - a)), where(own, 0.0, broadcast(cells, a))


@device
def add_row(cells, at, x, x_next, across):
    """Add to the columns of two neighbouring cells, by the weights ``across``."""
    store(cells, at, load(cells, at) + across * x)
    at += np.uint64(CELL)
    store(cells, at, load(cells, at) + across * x_next)


@device
def three(rows, row, k):
    """Three rows of lane k in single precision."""
    return np.float32(rows[row, k]), np.float32(rows[row + 1, k]), np.float32(rows[row + 2, k])


@device
def cell_of(rows, k, wide, layer):
    """Place of the cell before the sample of lane k."""
    x, y, z = np.int32(rows[BELOW, k]), np.int32(rows[BELOW + 1, k]), np.int32(rows[BELOW + 2, k])
    return np.uint64(x * CELL + y * wide + z * layer)


@device
def locate(moving, lattice, pack, sample, box, origins, rows):
    """Set the rows of scratch for a sample of a pack's strands. ``origins`` (3,): the middle of the box's first cell,
    metres."""
    positions, velocity, others = pointer(moving.positions), pointer(moving.velocity), pointer(moving.others)
    roots, out = pointer(moving.roots), pointer(rows)
    n = moving.velocity.shape[1]
    block = pack * PACK // W * (n + 2) * ROW + ROW + pack * PACK % W
    first, count = lattice.first[sample], lattice.counts[sample]
    for lane in range(0, PACK, lane_count(positions)):
        for c in range(3):
            x = broadcast(positions, 0.0)
            u = x
            for i in range(count):
                j = first + i
                weight = lattice.weights[sample, i]
                x += weight * (load(positions, block + j * ROW + c * W + lane) - origins[c])
                if j == 0:
                    u += weight * load(roots, (pack * 3 + c) * PACK + lane)
                else:
                    at = ((pack * n + j - 1) * 3 + c) * PACK + lane
                    u += weight * (load(velocity, at) + load(others, at))
            x *= lattice.inverse
            below = min(max(floor(x), 0.0), broadcast(x, box[SIZE + c] - 2))
            store(out, (SHARE + c) * PACK + lane, x - below)
            store(out, (BELOW + c) * PACK + lane, below)
            store(out, (VELOCITY + c) * PACK + lane, u)


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
