"""Boxes of cells about strands: of each part of them, and of all."""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import device, parallel, prange
from ...simd import any_lane, lane_count, load, pointer, reduce_max
from .crowd_records import BOX, FIRST, LANES, LAST, LOW, OFFSET, SIZE
from .rod_scratch import PACK

ROW = 3 * W
"""Numbers of a row of positions."""


@parallel
def find_boxes(positions, cell, parts, margin, most, ends, boxes):
    """Set the boxes about the strands of each part and of all, and return the cells of the last: NaN where a coordinate
    is not finite. Where they are more than ``most``, boxes stay as they are.

    positions (blocks, N + 2, 3 W); cell: side of a cell, metres; margin: cells that the box of all has beside strands;
    ends (parts, 6) float64, scratch; boxes (parts + 1, `BOX`) int64."""
    for part in prange(len(parts)):
        for axis in range(3):
            low, high = extent(positions, parts[part, FIRST] * PACK, parts[part, LAST] * PACK, axis)
            ends[part, axis] = np.floor(low / cell - 0.5)
            ends[part, 3 + axis] = np.floor(high / cell - 0.5) + 1
    return cut_boxes(ends, margin, most, boxes)


@device
def cut_boxes(ends, margin, most, boxes):
    """Set the boxes from the lowest and the highest cells of each part's strands, and return the cells of the last."""
    last = len(ends)
    cells = 1.0
    for axis in range(3):
        low, high = ends[0, axis], ends[0, 3 + axis]
        for part in range(last):
            if not (math.isfinite(ends[part, axis]) and math.isfinite(ends[part, 3 + axis])):
                return math.nan
            low, high = min(low, ends[part, axis]), max(high, ends[part, 3 + axis])
        cells *= high - low + 1 + 2 * margin
    if cells > most:
        return cells
    place = 0
    for part in range(last):
        size = 1
        for axis in range(3):
            low, high = np.int64(ends[part, axis]), np.int64(ends[part, 3 + axis])
            widen(boxes[last], axis, low, high, part == 0)
            boxes[part, LOW + axis], boxes[part, SIZE + axis] = low, high - low + 1
            size *= high - low + 1
        boxes[part, OFFSET] = place
        place += size
    for axis in range(3):
        boxes[last, LOW + axis] -= margin
        boxes[last, SIZE + axis] += 2 * margin
    boxes[last, SIZE] = -(-boxes[last, SIZE] // LANES) * LANES
    boxes[last, OFFSET] = 0
    return cells


@device
def widen(box, axis, low, high, first):
    """Extend a box along an axis to the cells from ``low`` to ``high``, or set it to them where they are the first."""
    if not first:
        low, high = min(low, box[LOW + axis]), max(high, box[LOW + axis] + box[SIZE + axis] - 1)
    box[LOW + axis], box[SIZE + axis] = low, high - low + 1


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


assert OFFSET + 1 == BOX
