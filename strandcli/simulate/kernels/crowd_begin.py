"""How far strands begin inside each other: see `crowd_overlap`."""

from __future__ import annotations

import numpy as np

from ...jit import device, function, parallel, prange
from .crowd_grid import locate
from .crowd_homes import LEAST_ROOM, home_at
from .crowd_records import BELOW, FIRST, FULL, LAST, MASS, SIZE
from .rod_scratch import PACK

INSIDE = np.float32(5)
"""Times as dense as allowed from which on strands are inside each other. A tie presses them to four or five times that,
and hair is to open behind it at once."""


@function
def find_shares(box, grid, open, numbers, homes, closed, shares):
    """Set the share of each cell's metres with which it is not too dense, ``shares`` (cells,), 1 where it is no denser
    than `INSIDE`. ``homes``, ``closed``: as `crowd_homes.settle` has left them; no rows where there are no solids."""
    for at in range(len(shares)):
        most, metres = numbers[FULL] * open[at], grid[MASS, at]
        inside = most > 0 and metres > INSIDE * max(most, LEAST_ROOM * numbers[FULL])
        shares[at] = most / metres if inside else np.float32(1)
    for far in range(2 if len(homes) > 0 else 0):
        for at in closed[far, 1 : 1 + closed[far, 0]]:
            if homes[at] > 0:
                shares[at] = shares[home_at(np.int64(at), homes[at], box)[0]]


@parallel
def find_overlap(moving, lattice, parts, box, shares, work, overlap):
    """Set ``overlap``, as `Moving` has it, from the shares of cells: of the eight around a sample the least."""
    for part in prange(len(parts)):
        for pack in range(parts[part, FIRST], parts[part, LAST]):
            for sample in range(len(lattice.first)):
                rows = work[part]
                locate(moving, lattice, (pack, pack), sample, box, lattice.origins[-1], rows)
                for k in range(PACK):
                    overlap[pack, sample, k] = np.sqrt(least(np.int64(rows[BELOW, k]), box, shares))


@device
def least(at, box, shares):
    """The least share of eight cells, of which ``at`` is the first."""
    found = shares[at]
    for corner in range(8):
        place = corner % 2 + box[SIZE] * (corner // 2 % 2 + box[SIZE + 1] * (corner // 4))
        found = min(found, shares[at + place])
    return found
