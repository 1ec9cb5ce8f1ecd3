"""The compiled step of the rod solver, on the arrays of one solver: that of `kernels.step`, or among custom solids a
module written for their kinds."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from ...compiling import runtime
from ...compiling.folder import module_of
from ...constants import VECTOR
from ...groom.blocks import aligned
from ...solids.custom import module_for
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
            custom = self._surroundings.custom
            self._code = work_queue.address(step_among(custom) if custom else step.run, given)
        # the other threads may be drawing frames: a step that took them away would wait for them
        workers = len(self.scratch)
        if workers > 1:
            workers = min(workers, numba.get_num_threads())
        work_queue.run_workers(self._code, given, self._queue, workers)


TEXT = '''\
"""A step of rods, written by strandcli.simulate.rod.step."""

from typing import Any, NamedTuple

from strandcli.jit import device, function
from strandcli.simd import fused_pointer
from strandcli.simulate.rod.kernels.step import contact_of, work
from {solids} import Custom as Shapes


class Custom(NamedTuple):
    """Solids without kernels of their own, as `strandcli.simulate.contact.kernels.search` takes them."""

    all: Any
    last: Any
    columns: Any


Custom.shapes = Shapes


@device
def custom_of(solids):
    rows = solids[4]
    return Custom(Shapes(fused_pointer(rows){data}), rows.size, rows.shape[1])


@function
def step(state, material, drive, step, needs, solids, scratch, queue, worker):
    work(state, material, drive, step, needs, contact_of(solids, custom_of(solids)), scratch, queue, worker)
'''


def step_among(custom: Sequence[Any]) -> Any:
    """`kernels.step.run` among solids of these kinds, whose rows and data follow those of the rest."""
    module = module_for(custom)
    data = "".join(f", solids[{5 + place}]" for place in range(len(module.Custom._fields) - 1))
    return _load(TEXT.format(solids=module.__name__, data=data)).step


@functools.cache
def _load(text: str) -> Any:
    return module_of(text, "rod", runtime.cache_folder())
