"""Metres and momentum of strands in the cells of a grid.

Segments are spread, and not particles, so that gaps between particles do not show: strands are sampled at points no
more than a cell apart, each of which counts for its share of them and goes to the eight cells around it by trilinear
weights. Where segments are shorter than cells, one sample stands for several, at the mean of the particles that it
stands between. Its velocity is as other forces are going to change it.
"""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device
from ....jit.indices import FIRST, SECOND, THIRD
from ....simd import (
    broadcast,
    floor,
    gather4,
    half_width_pointer,
    lane_count,
    load,
    load3,
    pointer,
    prefetch3,
    reduce_max,
    store,
    store3,
    store_records,
)
from ....simd.vectors import add_scaled, less, scaled
from ...rod.kernels.arrays import AXES, PACK, ROW
from . import records as rec

OWN = np.zeros((3, rec.CELL), np.float32)
"""1 in the column of what lies between middles along each axis, which counts wholly for the first of two cells."""
OWN[np.arange(3), rec.BETWEEN + np.arange(3)] = 1
REST = 1 - OWN


@device
def deposit_part(moving, samples, part, cells):
    """Set the cells that a part of the strands has, in a box of its own."""
    box, work = cells.boxes[part], (cells.scratch[part], cells.found[part])
    first, count = rec.CELL * box[rec.OFFSET], rec.CELL * box[rec.SIZE] * box[rec.SIZE + 1] * box[rec.SIZE + 2]
    own = cells.memory[first : first + count]
    own[...] = 0
    for pack in range(cells.parts[part, rec.FIRST], cells.parts[part, rec.LAST]):
        deposit_pack(moving, samples, pack, box, samples.origins[part], own, work)


@device
def deposit_pack(moving, samples, pack, box, origins, grid, work):
    """Add the metres and the momentum of a pack of strands to the cells of a box, ``grid`` (cells `CELL`,)."""
    cells, (rows, found) = half_width_pointer(grid), work
    each, wide = half_width_pointer(found), np.uint64(box[rec.SIZE] * rec.CELL)
    layer = wide * np.uint64(box[rec.SIZE + 1])
    for sample in range(len(samples.first)):
        locate(moving, samples, (pack, pack + 1), sample, box, origins, rows)
        # the columns of a cell that each strand's sample would fill alone, strand by strand
        for c in range(3):
            for k in range(PACK):
                found[(rec.CELL + c) * PACK + k] = rows[rec.VELOCITY + c, k]
        m = load(pointer(moving.metres), pack * PACK) * np.float32(samples.mass[sample])
        u, v, w = load3(pointer(found), rec.CELL * PACK, PACK)
        store_records(pointer(found), 0, (m, m * u, m * v, m * w, m, m, m, m * 0.0))
        for k in range(PACK):
            a, c, d = three(rows, rec.SHARE, k)
            x, x_next = weights_along(cells, FIRST, a)
            y, y_next = weights_along(cells, SECOND, c)
            z, z_next = weights_along(cells, THIRD, d)
            columns = load(each, k * rec.CELL)
            x *= columns
            x_next *= columns
            at = cell_of(rows, k)
            add_row(cells, at, x, x_next, y * z)
            add_row(cells, at + wide, x, x_next, y_next * z)
            add_row(cells, at + layer, x, x_next, y * z_next)
            add_row(cells, at + layer + wide, x, x_next, y_next * z_next)


@device
def weights_along(cells, axis, a):
    """The factors along an axis of the weights with which a sample counts in each column of a cell, and of the next
    one, to whose middle it has gone the share ``a``. What lies between middles counts for the first."""
    own, rest = load(half_width_pointer(OWN), rec.CELL * axis), load(half_width_pointer(REST), rec.CELL * axis)
    share = broadcast(cells, a)
    return max(1.0 - share, own), min(share, rest)


@device
def add_row(cells, at, x, x_next, across):
    """Add to the columns of two neighbouring cells, by the weights ``across``."""
    store(cells, at, load(cells, at) + across * x)
    at += np.uint64(rec.CELL)
    store(cells, at, load(cells, at) + across * x_next)


@device
def three(rows, row, k):
    """Three rows of lane k in single precision."""
    return np.float32(rows[row, k]), np.float32(rows[row + 1, k]), np.float32(rows[row + 2, k])


@device
def cell_of(rows, k):
    """Place of the cell before the sample of lane k."""
    return np.uint64(np.int32(rows[rec.BELOW, k])) * np.uint64(rec.CELL)


@device
def locate(moving, samples, packs, sample, box, origins, rows):
    """Set the rows of scratch for a sample of a pack's strands. ``packs``: that one, and the one whose particles are
    prefetched, for it comes next. ``origins`` (3,): the middle of the box's first cell, metres. What is read of arrays
    is read once: LLVM does not know that scratch is none of them."""
    positions, velocity, unloaded = pointer(moving.positions), pointer(moving.velocity), pointer(moving.unloaded)
    out, n = pointer(rows), moving.velocity.shape[1]
    first, count = samples.first[sample], samples.counts[sample]
    again, inverse = samples.again, samples.inverse
    origin = origins[0], origins[1], origins[2]
    pack, ahead = packs[0], (packs[1] - packs[0]) * n * AXES
    begin = pack * PACK // W * (n + 2) * ROW + ROW + pack * PACK % W
    next = packs[1] * PACK // W * (n + 2) * ROW + ROW + packs[1] * PACK % W - begin
    wide, high, deep = box[rec.SIZE], box[rec.SIZE + 1], box[rec.SIZE + 2]
    for lane in range(0, PACK, lane_count(out)):
        none = broadcast(out, 0.0)
        at = speed = none, none, none
        for i in range(count):
            weight, place = samples.weights[sample, i], begin + (first + i) * ROW + lane
            at = add_scaled(at, weight, less(load3(positions, place, W), origin))
            prefetch3(positions, place + next, W)
            if first + i == 0:
                own = load3(pointer(moving.roots), pack * AXES + lane, PACK)
            else:
                place = (pack * n + first + i - 1) * AXES + lane
                own, past = load3(velocity, place, PACK), load3(unloaded, place, PACK)
                prefetch3(velocity, place + ahead, PACK)
                prefetch3(unloaded, place + ahead, PACK)
                own = add_scaled(own, again, less(own, past))
            speed = add_scaled(speed, weight, own)
        x, y, z = scaled(inverse, at)
        below, above, behind = cell_before(x, wide), cell_before(y, high), cell_before(z, deep)
        store3(out, rec.SHARE * PACK + lane, PACK, x - below, y - above, z - behind)
        store(out, rec.BELOW * PACK + lane, below + above * wide + behind * (wide * high))
        store3(out, rec.VELOCITY * PACK + lane, PACK, speed[0], speed[1], speed[2])


@device
def cell_before(x, count):
    """Numbers of the cells before places along an axis, of so many."""
    return min(max(floor(x), 0.0), broadcast(x, count - 2))


@device
def merge_layer(boxes, o, memory, sums, grid, most):
    """Add the parts' cells of layer o of the box of all up, part by part, and set the ``most`` metres in a cell of each
    of its rows."""
    whole = boxes[len(boxes) - 1]
    wide, high, cells = whole[rec.SIZE], whole[rec.SIZE + 1], grid.shape[1]
    out, line, counted = pointer(grid), sums[o * high * wide * rec.CELL :], load(pointer(rec.COUNTED), 0)
    for n in range(high):
        row = (o * high + n) * wide
        if add_rows(boxes, o, n, half_width_pointer(memory), half_width_pointer(line)):
            found = broadcast(out, 0.0)
            for i in range(0, wide, rec.LANES):
                m, u, v, w = gather4(pointer(line), i * rec.CELL, counted, rec.CELL, 0.0)
                x, y, z, _ = gather4(pointer(line), i * rec.CELL + rec.BETWEEN, counted, rec.CELL, 0.0)
                store(out, rec.MASS * cells + row + i, m)
                store3(out, rec.MOMENTUM * cells + row + i, cells, u, v, w)
                store3(out, rec.BETWEEN * cells + row + i, cells, x, y, z)
                found = max(found, m)
            most[o, n] = reduce_max(found)
        else:
            most[o, n] = 0
            for c in range(rec.CELL):
                for i in range(0, wide, rec.LANES):
                    store(out, c * cells + row + i, 0.0)


@device
def add_rows(boxes, o, n, memory, line):
    """Set the cells of row n of layer o of the box of all to the sums of the parts', and return whether any has some
    there; else they stay as they are."""
    whole, found = boxes[len(boxes) - 1], False
    for part in range(len(boxes) - 1):
        box = boxes[part]
        inner, row = (
            o + whole[rec.LOW + 2] - box[rec.LOW + 2],
            n + whole[rec.LOW + 1] - box[rec.LOW + 1],
        )
        if inner < 0 or inner >= box[rec.SIZE + 2] or row < 0 or row >= box[rec.SIZE + 1]:
            continue
        if not found:
            for i in range(whole[rec.SIZE]):
                store(line, i * rec.CELL, 0.0)
        found = True
        at, source = (
            box[rec.LOW] - whole[rec.LOW],
            box[rec.OFFSET] + (inner * box[rec.SIZE + 1] + row) * box[rec.SIZE],
        )
        for i in range(box[rec.SIZE]):
            store(
                line,
                (at + i) * rec.CELL,
                load(line, (at + i) * rec.CELL) + load(memory, (source + i) * rec.CELL),
            )
    return found
