"""The compiled step of the rod solver, on the arrays of one solver."""

from __future__ import annotations

from functools import cache
from types import ModuleType
from typing import Any

import numba

from ..blocks import aligned
from ..constants import VECTOR
from .kernels import rod_descriptor, rod_step, rod_tension, work_queue
from .kernels.records import Flags, Forcing, Material, State
from .rod_others import module_among
from .surroundings import Surroundings

SEGMENTS_A_THREAD = 4_000
"""Segments of work that another thread is called for: waking it takes some hundredths of a millisecond."""

NOTHING: tuple[int, ...] = (0, 0, 0, 0, 0)
"""What is run beside a step otherwise."""


class StepKernel:
    """Runs the step on all threads that there is work for. The compiled code is given the addresses of the arrays: they
    are changed in place and never replaced."""

    def __init__(
        self, strands: int, iterations: int, flags: Flags, arrays: tuple[State, Material, Forcing],
        surroundings: Surroundings,
    ) -> None:  # fmt: skip
        edges = arrays[0].edges
        segments = edges.shape[1]
        workers = min(numba.get_num_threads(), 1 + strands * segments // SEGMENTS_A_THREAD)
        size = rod_tension.scratch_size(segments) * VECTOR
        self.scratch = aligned((workers, size // edges.itemsize), edges.dtype)
        """(workers, size)."""
        self._kept = arrays, surroundings.solids(0.0, 0.0)
        self._surroundings, self._data = surroundings, surroundings.data
        self._descriptor = rod_descriptor.descriptor_of(
            strands, segments, iterations, flags, self.scratch, *self._kept, self._data
        )
        self._alone = *NOTHING[:3], arrays[0].crowd.ctypes.data, 0
        self._beside: tuple[int, ...] = ()
        self._others = surroundings.others
        self._kind, self._flags = edges.dtype.name, flags
        self._code: int | None = None

    def run(self, beside: tuple[int, ...] = NOTHING) -> None:
        """Move all strands by one step, as `Forcing` says. ``beside``: code that is run before each pack and after it,
        as `work_queue.call_for` takes it, and the address of its descriptor; where it leaves accelerations, and bytes
        between those of two workers. Strands that interact have such."""
        if beside is not self._beside:
            self._descriptor[rod_descriptor.BEFORE : rod_descriptor.CROWD_BYTES + 1] = (
                beside if beside[2] else self._alone
            )
            self._beside = beside
        if self._code is None:  # compiled no sooner than anything moves, which need not be
            self._code = self._compiled()
        if self._data is not self._surroundings.data:
            self._data = self._surroundings.data
            self._descriptor[rod_descriptor.DATA :] = rod_descriptor.data_numbers(self._data)
        # the other threads may be drawing frames: a step that took them away would wait for them
        workers = len(self.scratch)
        if workers > 1:
            workers = min(workers, numba.get_num_threads())
        work_queue.run_workers(self._code, self._descriptor, workers)

    def _compiled(self) -> int:
        """Return the address of the step that the scene needs: a shipped one, or one of a module written for it."""
        crowded = self._flags.crowded
        if self._others:
            return _address(module_among(self._others, self._data, self._kind, crowded), "step")
        kind = "double" if self._kind == "float64" else "single"
        return _address(rod_step, kind + ("_crowded" if crowded else ""))

    def __deepcopy__(self, memo: Any) -> StepKernel:
        raise TypeError("a rod solver cannot be copied, for its kernel holds addresses of arrays: make another one")


@cache
def _address(module: ModuleType, function: str) -> int:
    """Address of a step's machine code."""
    return work_queue.address(getattr(module, function))
