"""A work queue, from which threads take tasks one after the other, so that none waits for a slow one.

A descriptor, an int64 array, holds what all threads need: the number of the next task, how many tasks there are, and
then what the work itself reads, such as addresses. Numba compiles the body of a parallel loop three times, with all
that it calls; so here that body calls compiled code by its address.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.core import types
from numba.core.extending import intrinsic
from numpy.typing import NDArray

from ...jit import function, parallel, prange

DESCRIPTOR = types.Array(types.int64, 1, "C")
NEXT, TASKS = 0, 1
"""Columns of a descriptor."""


@intrinsic
def take(typingctx: Any, descriptor: Any) -> Any:
    """The number of the next task, taken by an atomic increment."""
    if descriptor != DESCRIPTOR:
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, value=args[0]).data
        return builder.atomic_rmw("add", data, context.get_constant(types.int64, 1), "monotonic")

    return types.int64(descriptor), emit


@intrinsic
def call(typingctx: Any, code: Any, descriptor: Any, worker: Any) -> Any:
    """Run the code at an address that `address` gave."""

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = context.call_conv.get_function_type(types.none, sig.args[1:])
        there = builder.inttoptr(args[0], kind.as_pointer())
        context.call_conv.call_function(builder, there, types.none, sig.args[1:], args[1:])
        return context.get_dummy_value()

    return types.none(types.int64, DESCRIPTOR, types.int64), emit


def share_out(code: int, descriptor: NDArray[np.int64], workers: int) -> None:
    """Run code once for each of ``workers``, which is given its number; a single one runs on the calling thread."""
    if workers > 1:
        on_threads(code, descriptor, workers)
    else:
        on_this(code, descriptor)


@parallel
def on_threads(code, descriptor, workers):
    """`share_out` where there are several."""
    for worker in prange(workers):
        call(code, descriptor, np.int64(worker))


@function
def on_this(code, descriptor):
    """`share_out` by the thread that calls."""
    call(code, descriptor, 0)


def address(function: Any) -> int:
    """Address of the machine code of a function of a descriptor and a worker's number; compiles it."""
    signature = DESCRIPTOR, types.int64
    function.compile(signature)
    made = function.overloads[signature]
    return int(made.library.get_pointer_to_function(made.fndesc.llvm_func_name))
