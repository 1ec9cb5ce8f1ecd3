"""Work queue: threads take one task after the other, so that none waits for a slow one.

A descriptor, an int64 array, has the number of the next task, the number of tasks, and then data of the work itself,
such as addresses. Numba compiles the body of a parallel loop three times, with all functions that it calls; so that
body calls compiled code by its address.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.core import types
from numba.core.extending import intrinsic
from numpy.typing import NDArray

from ...jit import device, function, parallel, prange
from ...simd import array_at

DESCRIPTOR = types.Array(types.int64, 1, "C")
NEXT, TASKS = 0, 1
"""Columns of a descriptor."""


@intrinsic
def take(typingctx: Any, descriptor: Any) -> Any:
    """Return the number of the next task, and increment it atomically."""
    if descriptor != DESCRIPTOR:
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, value=args[0]).data
        return builder.atomic_rmw("add", data, context.get_constant(types.int64, 1), "monotonic")

    return types.int64(descriptor), emit


def _calling(count: int) -> Any:
    """Code at an address from `address`, called with a descriptor and so many numbers."""

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = context.call_conv.get_function_type(types.none, sig.args[1:])
        there = builder.inttoptr(args[0], kind.as_pointer())
        context.call_conv.call_function(builder, there, types.none, sig.args[1:], args[1:])
        return context.get_dummy_value()

    return types.none(types.int64, DESCRIPTOR, *[types.int64] * count), emit


@intrinsic
def call(typingctx: Any, code: Any, descriptor: Any, worker: Any) -> Any:
    """Call the code at an address from `address`."""
    return _calling(1)


@intrinsic
def call_for(typingctx: Any, code: Any, descriptor: Any, task: Any, next: Any, worker: Any) -> Any:
    """The same of code that takes a task's number, that of the worker's next one and the worker's."""
    return _calling(3)


@device
def call_beside(code, descriptor, task, next, worker):
    """Run what is to be run before or after a task: code at an address, with the descriptor at one, unless it is 0.
    ``next``: the number of the task that the worker has after it."""
    if code != 0:
        call_for(code, array_at(np.int64, descriptor, (1,)), task, next, worker)


def run_workers(code: int, descriptor: NDArray[np.int64], workers: int) -> None:
    """Run the code at an address once for each of ``workers``, with the worker's number, from the first task on; a
    single worker runs on the calling thread."""
    if workers > 1:
        on_threads(code, descriptor, workers)
    else:
        on_this(code, descriptor)


@parallel
def on_threads(code, descriptor, workers):
    """Run `run_workers` on several threads."""
    descriptor[NEXT] = 0
    for worker in prange(workers):
        call(code, descriptor, np.int64(worker))


@function
def on_this(code, descriptor):
    """Run `run_workers` on the calling thread."""
    descriptor[NEXT] = 0
    call(code, descriptor, 0)


def address(function: Any, numbers: int = 1) -> int:
    """Compile a function of a descriptor and a worker's number, or of so many; return the address of its machine
    code."""
    signature = DESCRIPTOR, *[types.int64] * numbers
    function.compile(signature)
    made = function.overloads[signature]
    return int(made.library.get_pointer_to_function(made.fndesc.llvm_func_name))
