"""The compiled step of the rod solver, on the arrays of one solver."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from ...blocks import aligned
from ...constants import VECTOR
from .custom import step_among
from .kernels import step, work_queue
from .kernels.arrays import PACK, Drive, Material, Needs, State, Step
from .kernels.scratch import vectors_for
from .surroundings import Surroundings

SEGMENTS_A_THREAD = 4_000
"""Segments of work that another thread is called for: waking it takes some hundredths of a millisecond."""


class StepKernel:
    """Runs the step on all threads that there is work for."""

    def __init__(self, strands: int, arrays: tuple[State, Material, Drive], surroundings: Surroundings) -> None:
        edges = arrays[0].edges
        segments = edges.shape[1]
        workers = min(numba.get_num_threads(), 1 + strands * segments // SEGMENTS_A_THREAD)
        self.scratch: NDArray[Any] = aligned((workers, vectors_for(segments) * VECTOR // edges.itemsize), edges.dtype)
        """(workers, size)."""
        self._arrays, self._surroundings = arrays, surroundings
        self._solids = surroundings.solids(0.0, 0.0)
        self._queue = np.array([0, -(-strands // PACK)])
        self._code: int | None = None

    def run(self, now: Step, needs: Needs) -> None:
        """Move all strands by one step."""
        data = tuple(self._surroundings.data)
        given = (*self._arrays, now, needs, (*self._solids, *data), self.scratch, self._queue)
        if self._code is None:  # compiled no sooner than anything moves, which need not be
            others = self._surroundings.others
            self._code = work_queue.address(step_among(others) if others else step.run, given)
        # the other threads may be drawing frames: a step that took them away would wait for them
        workers = len(self.scratch)
        if workers > 1:
            workers = min(workers, numba.get_num_threads())
        work_queue.run_workers(self._code, given, self._queue, workers)
