"""The order in which threads share tasks: each task once, and neighbours far apart."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from strandcli.jit.balance import TURNS, places, task_at


@njit
def order(count):
    out = np.empty(places(count), np.int64)
    for place in range(len(out)):
        out[place] = task_at(np.int64(place), count)
    return out


@given(st.integers(0, 3000))
def test_each_task_has_its_turn_once(count: int) -> None:
    found = order(np.int64(count))
    assert sorted(found[found < count]) == list(range(count))
    assert len(found) < count + TURNS


@given(st.integers(200, 3000), st.sampled_from([2, 4, 8]))
def test_threads_have_alike_parts_of_all(count: int, threads: int) -> None:
    """The mean number of a thread's tasks is that of all, within a few."""
    found = order(np.int64(count))
    for part in np.array_split(found, threads):
        assert abs(part[part < count].mean() - (count - 1) / 2) < 2 * TURNS
