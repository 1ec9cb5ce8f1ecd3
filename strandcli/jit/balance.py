"""An order of tasks in which neighbours are far apart.

Each thread takes a contiguous part of a parallel loop. Where tasks are parts of a picture or of a groom, one thread
would have the sky and another the grass; in this order all threads have alike parts of both.
"""

from __future__ import annotations

import numpy as np

from . import inlined

TURNS = np.int64(16)
"""Tasks `TURNS` apart follow each other."""


@inlined
def places(count: np.int64) -> np.int64:
    """Return how many places a loop over `count` tasks has: see `task_at`."""
    return (count + TURNS - 1) // TURNS * TURNS


@inlined
def task_at(place: np.int64, count: np.int64) -> np.int64:
    """Return the number of the task at a place of the loop; `count` or more where there is none."""
    rounds = (count + TURNS - 1) // TURNS
    return place % rounds * TURNS + place // rounds
