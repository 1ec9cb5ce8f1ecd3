"""A grid's step, phase by phase: strands in its cells, pressure and shelter, and what these do to the strands."""

from __future__ import annotations

from typing import Any, NamedTuple

from ....jit import function
from ....jit.tasks import PHASE, TASKS, take
from .forces import accelerate_part, find_targets, shelter
from .pressure import find_excess, limit, relax
from .records import LIVE, MASS
from .transfer import deposit_part, merge_layer

DEPOSIT, MERGE, EXCESS, PRESS, TARGETS, ACCELERATE = range(6)
"""Phases, whose tasks are parts of the strands, layers of the box of all, layers, `PRESSES`, layers, and parts."""
PRESSES = 2
"""One finds pressure, and one shelter."""


class Cells(NamedTuple):
    """The grid: parts of the strands, each with cells in a box of its own, and the box of all."""

    parts: Any
    """(parts, 2) int64, as `records.FIRST` has it."""
    boxes: Any
    """(parts + 1, `BOX`) int64, the last that of all."""
    memory: Any
    """(cells of all parts times `CELL`,)"""
    scratch: Any
    """(parts, `ROWS`, S)"""
    found: Any
    """(parts, `FOUND` S)"""
    columns: Any
    """(`CELL`, cells)"""
    most: Any
    """Metres in a cell at the most, by rows of cells: (cells along z, cells along y)."""
    near: Any
    """Whether strands are in a row or in one of the eight around; as above. What rows hold that are not is neither set
    nor read."""
    room: Any
    """`Room`."""
    numbers: Any
    """(`NUMBERS`,) float32"""
    margined: Any
    live: Any
    """As `pressure.relax` takes them."""
    pressure: Any
    """(cells,) of the step before at first."""
    targets: Any
    """(cells times `CELL`,)"""
    shares: Any
    """(samples, greatest count) of a sample's change that its particles have, 1/s."""
    accelerations: Any
    """(P, N, 3 S) of particles, m/s²."""


@function
def run(moving, samples, cells, queue, worker):
    """Run tasks of a phase."""
    phase, box, task = queue[PHASE], cells.boxes[len(cells.parts)], take(queue)
    while task < queue[TASKS]:
        if phase == DEPOSIT:
            deposit_part(moving, samples, task, cells)
        elif phase == MERGE:
            merge_layer(cells.boxes, task, cells.memory, cells.targets, cells.columns, cells.most)
        elif phase == EXCESS:
            find_excess(box, task, cells.near, cells.columns, cells.room, cells.pressure, cells.numbers)
        elif phase == PRESS and task == 0:
            relax(box, cells.room, cells.near, cells.margined, cells.live, cells.pressure)
            limit(box, cells.columns, cells.room, cells.numbers, cells.live[LIVE], cells.pressure)
        elif phase == PRESS:
            shelter(box, cells.columns[MASS], cells.numbers, cells.room.left, cells.room.behind)
        elif phase == TARGETS:
            find_targets(box, task, cells.near, cells.columns, cells.room, cells.numbers, cells.pressure, cells.targets)
        else:
            accelerate_part(moving, samples, task, cells)
        task = take(queue)
