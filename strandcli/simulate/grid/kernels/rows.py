"""Cells of a row and those beside them, a vector of `LANES` along x at once.

Columns of cells are planes, one number a cell, x fastest. Beside the box cells are as a kernel says: what is loaded
for them is of another row, and not used.
"""

from __future__ import annotations

import numpy as np

from ....jit import device
from ....simd import broadcast, load, pointer
from .records import LANES

REACH = 2
"""Cells on either side that are looked at."""
WITHIN = np.concatenate([np.zeros(REACH), np.ones(2 * LANES), np.zeros(REACH)]).astype(np.float32)
"""1 for cells within a row that is two vectors long."""
COUNTED = np.arange(LANES).astype(np.float32)
"""Numbers of lanes."""


@device
def beside_along(i, wide):
    """Ways from the cells of a vector, of which the first is cell i of its row, to those one before, one after, two
    before and two after, and masks of those that there are."""
    rows = pointer(WITHIN)
    first = REACH + (LANES if i > 0 else 0)
    last = REACH + (0 if i < wide - LANES else LANES)
    ways = np.int64(-1), np.int64(1), np.int64(-2), np.int64(2)
    return ways, (
        load(rows, first - 1) > 0.0, load(rows, last + 1) > 0.0, load(rows, first - 2) > 0.0, load(rows, last + 2) > 0.0
    )  # fmt: skip


@device
def beside_across(place, count, stride):
    """The same across rows, of the row or layer at a place of so many, a ``stride`` apart: where there is none, the way
    is none."""
    a, b = place > 0, place < count - 1
    c, d = place > 1, place < count - 2
    ways = -stride * np.int64(a), stride * np.int64(b), -2 * stride * np.int64(c), 2 * stride * np.int64(d)
    return ways, (all_or_none(a), all_or_none(b), all_or_none(c), all_or_none(d))


@device
def all_or_none(holds):
    """A mask that holds in all lanes, or in none."""
    return broadcast(pointer(WITHIN), np.float32(holds)) > 0.0
