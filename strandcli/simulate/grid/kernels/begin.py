"""How far strands begin inside each other: see `overlap`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ....jit import device, function, parallel, prange
from ...rod.kernels.arrays import PACK
from .donor_cells import LEAST_ROOM, home_at
from .records import BELOW, FIRST, FULL, LAST, MASS, SIZE
from .transfer import locate

INSIDE = np.float32(5)
"""Times as dense as allowed from which on strands are inside each other. A tie presses them to four or five times that,
and hair is to open behind it at once."""
STAY, BACK = 0.6, 1.2
"""Shares of `Pace.most` from which on nothing is led apart any more, and from which on it goes back. Were both one,
strands would fidget for ever."""


class Pace(NamedTuple):
    """How strands that begin inside each other are led apart in a step."""

    step: Any
    """By which share of what it was at the start the root of a sample's share grows, where there is no pressure."""
    most: Any
    """Pressure over the metres in a cell that strands are led apart by at the most."""
    inside: Any
    """Metres in a cell up to which what counts wholly once does so for good."""


@function
def find_shares(box, grid, open, numbers, homes, closed, shares):
    """Set the share of each cell's metres with which it is not too dense, ``shares`` (cells,), 1 where it is no denser
    than `INSIDE`. ``homes``, ``closed``: as `donor_cells.settle` has left them; no rows where there are no solids."""
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


@parallel
def lead_apart(moving, lattice, parts, box, grid, pressure, pace, work, begun, overlap):
    """Go on by a step with ``overlap``, as `Moving` has it, from what it was at the start, ``begun`` (P, samples, S),
    at a `Pace`. Return whether any is less than 1. ``pressure``: (cells,) that of the step."""
    some = np.zeros(len(parts), np.bool_)
    for part in prange(len(parts)):
        for pack in range(parts[part, FIRST], parts[part, LAST]):
            for sample in range(len(lattice.first)):
                rows = work[part]
                locate(moving, lattice, (pack, pack), sample, box, lattice.origins[-1], rows)
                for k in range(PACK):
                    least = begun[pack, sample, k]
                    if least < 1:
                        held, metres = pressed(np.int64(rows[BELOW, k]), box, grid, pressure)
                        root = led(least, overlap[pack, sample, k], held, metres, pace)
                        overlap[pack, sample, k] = root
                        some[part] |= root < 1
    return some.any()


@device
def led(least, root, held, metres, pace):
    """The root of a sample's share after a step, from that before and at the start. One that counts wholly does so for
    good, but where strands are inside each other again."""
    if root == 1 and metres <= pace.inside:
        return root
    much = held / pace.most
    if much < STAY:
        root += least * pace.step * (1 - much / STAY)
    elif much > BACK:
        root -= least * pace.step * min(much - BACK, 1)
    return min(max(root, least), 1)


@device
def pressed(at, box, grid, pressure):
    """The most pressure in eight cells, of which ``at`` is the first, over the most metres in one; and these."""
    most, metres = np.float32(0), np.float32(1e-30)
    for corner in range(8):
        place = corner_at(at, corner, box)
        most, metres = max(most, pressure[place]), max(metres, grid[MASS, place])
    return most / metres, metres


@device
def least(at, box, shares):
    """The least share of eight cells, of which ``at`` is the first."""
    found = shares[at]
    for corner in range(8):
        found = min(found, shares[corner_at(at, corner, box)])
    return found


@device
def corner_at(at, corner, box):
    """One of eight cells, of which ``at`` is the first."""
    return at + corner % 2 + box[SIZE] * (corner // 2 % 2 + box[SIZE + 1] * (corner // 4))
