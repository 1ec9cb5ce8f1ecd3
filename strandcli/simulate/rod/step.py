"""The compiled step of the rod solver, `kernels.step`, on the arrays of one solver."""

from __future__ import annotations

from typing import Any

import numba
from numpy.typing import NDArray

from ...constants import VECTOR
from ...groom.blocks import aligned
from ...jit.tasks import Tasks
from ...solids.custom import module_for
from .kernels import step
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
        self._packs = -(-strands // PACK)
        self._tasks = Tasks(step.run)

    def run(self, now: Step, needs: Needs) -> None:
        """Move all strands by one step."""
        solids, custom = self._solids, self._surroundings.custom
        if custom:
            solids = (*solids[:-1], module_for(custom).Custom(solids[-1], *self._surroundings.data))
        self._tasks.bind((*self._arrays, now, needs, solids, self.scratch))
        # the other threads may be drawing frames: a step that took them away would wait for them
        workers = len(self.scratch)
        if workers > 1:
            workers = min(workers, numba.get_num_threads())
        self._tasks.run(self._packs, workers)
