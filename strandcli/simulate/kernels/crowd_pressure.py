"""Pressure where strands are too dense, by one-sided projection on the grid.

Density φ is relative to the greatest allowed. In a step of h with the momentum m v that cells are going to have it
would be φ* = φ − h ∇·(φ v). Pressure p >= 0 accelerates cells along −∇p, so that it becomes φ* + ∇²p (p here times h²
over the cell's area): p is the least with which φ* + ∇²p <= 1, and is 0 wherever there is room,

    6 p_c − Σ p_d >= e_c,    p_c >= 0,    one of both equal,    e = φ* − 1,

a linear complementarity problem, solved by projected overrelaxation (Cryer 1971) that begins with the pressure of the
step before. Narain et al. 2009 push granular matter apart in the same way.

Unconditionally stable. With trilinear weights and central differences strands give way by no more than the Laplacian
promises, and strands that hang together by less still: so one step never makes up for more than the density in excess.
At rest the contacts' forces take part in v: they are in balance with the pressure if φ is 1, so that the density does
not depend on the load nor on the step.
"""

from __future__ import annotations

from ...jit import device, function, parallel, prange
from .crowd_records import MASS, MOMENTUM, SIZE

RELAXATION = 1.5
ROUNDS = 12
"""Sweeps of a step: the pressure of the step before is nearly right already."""


@parallel
def find_excess(box, grid, full, ratio, most, excess):
    """Set e, ``excess`` (cells,). ``full``: metres in a cell that is as dense as allowed; ``ratio``: half the step over
    the cell's side, s/m; ``most``: by how much of the density that there is too much of pressure makes up in a step."""
    wide, high = box[SIZE], box[SIZE + 1]
    layer = wide * high
    last = box[SIZE + 2] - 1
    for o in prange(box[SIZE + 2]):
        for n in range(high):
            row = o * layer + n * wide
            for i in range(wide):
                at = row + i
                flow = 0.0
                if i > 0:
                    flow += grid[at - 1, MOMENTUM]
                if i < wide - 1:
                    flow -= grid[at + 1, MOMENTUM]
                if n > 0:
                    flow += grid[at - wide, MOMENTUM + 1]
                if n < high - 1:
                    flow -= grid[at + wide, MOMENTUM + 1]
                if o > 0:
                    flow += grid[at - layer, MOMENTUM + 2]
                if o < last:
                    flow -= grid[at + layer, MOMENTUM + 2]
                excess[at] = min(grid[at, MASS] / full - 1, most) + ratio * flow / full


@function
def relax(box, excess, pressure):
    """Sweep over the cells `ROUNDS` times, rows of one colour after those of the other. Rows in which no strand can be
    too dense and which have no neighbour with pressure are passed over."""
    wide, high, deep = box[SIZE], box[SIZE + 1], box[SIZE + 2]
    for round in range(2 * ROUNDS):
        for o in range(deep):
            for n in range((o + round) % 2, high, 2):
                relax_row(o, n, wide, high, deep, excess, pressure)


@device
def relax_row(o, n, wide, high, deep, excess, pressure):
    """Relax the cells of a row, from one end to the other."""
    layer = wide * high
    row = o * layer + n * wide
    for i in range(wide):
        at = row + i
        around = 0.0
        if i > 0:
            around += pressure[at - 1]
        if i < wide - 1:
            around += pressure[at + 1]
        if n > 0:
            around += pressure[at - wide]
        if n < high - 1:
            around += pressure[at + wide]
        if o > 0:
            around += pressure[at - layer]
        if o < deep - 1:
            around += pressure[at + layer]
        p = pressure[at]
        pressure[at] = max(p + RELAXATION * ((excess[at] + around) / 6 - p), 0.0)
