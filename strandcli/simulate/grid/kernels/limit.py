"""Pressure that throws no strand: as great as it may be.

Where strands are far too dense beside room, as when thousands begin inside each other, what pressure hands to the few
at the edge would throw them by dozens of cells. On a face it may stop what comes against it and what falls against it,
hold what it held before, and hasten what it leads apart by a, or bring it to the speed w:

    p_c − p_d <= m (max(a + max(−v, 0), w − v) + max(−g, 0)) + HELD max(p'_c − p'_d, 0),    a = 2 s², w = s

of the metres m that the impulse on the face moves, their velocity v from c to d, gravity's change g of it, all in cells
a step, the pressure p' of the step before, and the share s of the density that it makes up for in the step at the most,
`numbers[MOST]`. It is a half of long steps, where a, half a cell, is what counts. Where steps are short s is in
proportion to them, and a is an acceleration and w a speed that do not depend on how short: steps that are cut into many
for coils add up, and half a cell in each would throw strands. Of all pressures that are no greater than what was found,
the greatest with that is taken: the least of sums along all ways from a cell, which sweeps to and fro find. Impulses
are those of a pressure still, so that sums of momentum stay.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, function
from ....simd import any_lane, load, pointer
from .records import BETWEEN, FALL, FULL, LANES, MASS, MOMENTUM, MOST, SIZE, SPEED

HASTENED, LED = np.float32(2), np.float32(1)
"""a over s², and w over s. With w alone strands that move on together could not be held; with a alone curls that press
each other are a tenth denser than with half a cell a step at any length. With w = s / 2 a tuft stands 5.5 % too low at
60 steps a second."""
SWEEPS = 8
"""To and fro, at the most."""
BETWEEN_ONLY = np.float32(0.5)
"""Share of the impulse on a face of two cells that goes to what lies between their middles. Were there none, cells of
which every other one is dense would feel no pressure at all, and strands would gather in them; were it all, few strands
that lie there would be thrown."""
WIDELY = np.float32(0.5) * (1 - BETWEEN_ONLY)
"""And the share that each of the cells gets, by trilinear weights."""
SLIVER = np.float32(1e-4)
"""Share of a full cell about a face below which the impulse on it is not all handed on: what rounding places there in
one sum, and not in another, would be thrown."""


@device
def moved(at, next, axis, grid, least):
    """Metres that the impulse on the face of two cells moves, at least so many."""
    m = WIDELY * (grid[MASS, at] + grid[MASS, next]) + BETWEEN_ONLY * grid[BETWEEN + axis, at]
    return max(m, least)


@function
def limit(box, busy, grid, room, numbers, pressure):
    """Lower the ``pressure`` (cells,) where it is more than it may be. busy (2, cells along z + 2, along y + 2): of
    them the second is 0 for rows of cells without any, as `pressure.relax` leaves it; the first is scratch: not 0
    for rows to look at, since something in them or beside them has been lowered."""
    wide, high, rows, p = box[SIZE], box[SIZE + 1], box[SIZE + 1] * box[SIZE + 2], pointer(pressure)
    wanted, live = busy[0], busy[1]
    for row in range(rows):
        wanted[row // high + 1, row % high + 1] = live[row // high + 1, row % high + 1]
    for sweep in range(2 * SWEEPS):
        lowered, back = False, sweep % 2 == 1
        for k in range(rows):
            row = rows - 1 - k if back else k
            o, n = row // high + 1, row % high + 1
            if wanted[o, n] == 0:
                continue
            wanted[o, n] = 0
            changed = False
            for i in range(0, wide, LANES):
                first = row * wide + (wide - LANES - i if back else i)
                if any_lane(load(p, first) > 0.0):
                    for lane in range(LANES):
                        at = first + (LANES - 1 - lane if back else lane)
                        if pressure[at] > 0:
                            changed |= limit_cell(at, box, grid, room, numbers, pressure)
            if changed:
                lowered = True
                for i in range(-1, 2):
                    wanted[o + i, n] = live[o + i, n]
                    wanted[o, n + i] = live[o, n + i]
        if not lowered:
            break


@device
def limit_cell(at, box, grid, room, numbers, pressure):
    """Lower the pressure of a cell, and return whether it was."""
    stride, most = 1, pressure[at]
    for axis in range(3):
        place = at // stride % box[SIZE + axis]
        if place > 0:
            most = min(most, greatest(at, at - stride, at - stride, axis, -1, grid, room, numbers, pressure))
        if place < box[SIZE + axis] - 1:
            most = min(most, greatest(at, at + stride, at, axis, 1, grid, room, numbers, pressure))
        stride *= box[SIZE + axis]
    lowered = most < pressure[at]
    pressure[at] = most
    return lowered


@device
def greatest(at, next, first, axis, way, grid, room, numbers, pressure):
    """The greatest pressure of a cell by that of a neighbour, its own if it is no more; ``first``: the one of both
    before the face."""
    if room.aperture[next] <= 0 or pressure[at] <= pressure[next]:
        return pressure[at]
    full = numbers[FULL]
    face = full * room.aperture[at] * room.aperture[next]
    m = moved(first, at + next - first, axis, grid, SLIVER * full) / face
    both = max(grid[MASS, at] + grid[MASS, next], SLIVER * full)
    apart = HASTENED * numbers[MOST] * numbers[MOST]
    if pressure[at] <= pressure[next] + m * apart:
        return pressure[at]
    against = (grid[MOMENTUM + axis, at] + grid[MOMENTUM + axis, next]) / both * -way / numbers[SPEED]
    held = max(room.held[at] - room.held[next], np.float32(0))
    fall = -way * numbers[FALL + axis]
    led = max(apart + max(against, np.float32(0)), LED * numbers[MOST] + against)
    return pressure[next] + held + m * (led + max(fall, np.float32(0)))
