"""Indices and truth values that compiled functions are given and find, and an order of tasks in which neighbours are
far apart.

For each literal of these types Numba would compile a function again. With `np.searchsorted` a cached kernel has Numba
import its linear algebra before it is run, and that SciPy's: a fifth of a second. Each thread takes a contiguous part
of a parallel loop: where tasks are parts of a picture or of a groom, one thread would have the sky and another the
grass; in the order of `task_at` all threads have alike parts of both.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import device, inlined

FIRST, SECOND, THIRD = np.int64(0), np.int64(1), np.int64(2)
YES, NO = np.True_, np.False_
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


@device
def first_not_below(ascending: Any, x: Any) -> Any:
    """Return how many numbers are less than x."""
    low, high = np.int64(0), np.int64(ascending.shape[0])
    while low < high:
        middle = (low + high) >> 1
        if ascending[middle] < x:
            low = middle + 1
        else:
            high = middle
    return low


@device
def first_above(ascending: Any, x: Any) -> Any:
    """Return how many numbers are not greater than x."""
    low, high = np.int64(0), np.int64(ascending.shape[0])
    while low < high:
        middle = (low + high) >> 1
        if ascending[middle] <= x:
            low = middle + 1
        else:
            high = middle
    return low
