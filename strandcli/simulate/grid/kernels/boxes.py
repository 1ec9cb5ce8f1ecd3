"""Boxes of cells about strands: of each part of them, and of all."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, function
from .records import BOX, FIRST, LANES, LAST, LOW, OFFSET, SIZE


@function
def find_boxes(found, cell, parts, margin, most, ends, boxes, before, origins):
    """Set the boxes about the strands of each part and of all. Return the cells of the last, NaN where a coordinate is
    not finite; the cells of all parts; and whether the box of all has changed. Where cells are more than ``most``,
    boxes stay as they are.

    found: `Moving.ends`; cell: side of a cell, metres; margin: cells that the box of all has beside these;
    ends (parts, 6) float64, scratch; boxes (parts + 1, `BOX`) int64; before (`BOX`,): is set to the box of all as it
    was; origins: `Lattice.origins`, are set."""
    for part in range(len(parts)):
        for axis in range(3):
            low, high = found[parts[part, FIRST], axis], found[parts[part, FIRST], 3 + axis]
            for pack in range(parts[part, FIRST], parts[part, LAST]):
                low, high = max(low, found[pack, axis]), max(high, found[pack, 3 + axis])
            ends[part, axis] = np.floor(-low / cell - 0.5)
            ends[part, 3 + axis] = np.floor(high / cell - 0.5) + 1
    last, changed = len(parts), False
    for column in range(BOX):
        before[column] = boxes[last, column]
    cells = cut_boxes(ends, margin, most, boxes)
    for part in range(last + 1):
        for axis in range(3):
            origins[part, axis] = cell * (boxes[part, LOW + axis] + 0.5)
    for column in range(BOX):
        changed |= before[column] != boxes[last, column]
    past = boxes[last - 1]
    return cells, past[OFFSET] + past[SIZE] * past[SIZE + 1] * past[SIZE + 2], changed


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


assert OFFSET + 1 == BOX
