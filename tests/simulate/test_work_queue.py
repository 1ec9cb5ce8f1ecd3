"""The queue by which threads share tasks, and arguments that are handed on by address."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit

from strandcli.simulate.rod.kernels import work_queue
from strandcli.simulate.rod.kernels.work_queue import TASKS, take


class Given(NamedTuple):
    """Arguments of several kinds under one name."""

    rows: Any
    pair: Any
    """(float, bool)"""


@njit
def work(given, count, queue, worker):
    """Mark each task with its number, and who has done it."""
    task = take(queue)
    while task < queue[TASKS]:
        given.rows[task, 0] += given.pair[0] * task + count
        given.rows[task, 1] = worker if given.pair[1] else -1
        task = take(queue)


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_every_task_is_done_once_with_the_arguments_that_are_given(workers: int) -> None:
    """More workers than threads, too, and again by the same code."""
    rows, queue = np.zeros((1000, 2)), np.array([5, 1000])
    arguments = Given(rows, (0.5, True)), 3, queue
    code = work_queue.address(work, arguments)
    for again in (1, 2):
        work_queue.run_workers(code, arguments, queue, workers)
        np.testing.assert_array_equal(rows[:, 0], again * (0.5 * np.arange(1000) + 3))
    assert set(rows[:, 1]) <= set(range(workers))
    work_queue.run_workers(code, (Given(rows, (0.5, False)), 3, queue), queue, workers)
    assert (rows[:, 1] == -1).all()
