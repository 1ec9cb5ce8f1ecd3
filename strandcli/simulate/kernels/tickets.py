"""Work handed out to threads as they come for it, so that none waits for one that began late or has more to do.

What all threads need is in a book, an int64 array: first the number of the next ticket, then how many there are, then
whatever the code asks for that does the work, such as addresses. Numba compiles the body of a parallel loop three times
over, with all that it calls. So that body calls code that has been compiled before, by its address.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.core import types
from numba.core.extending import intrinsic
from numpy.typing import NDArray

from ...jit import function, parallel, prange

BOOK = types.Array(types.int64, 1, "C")
NEXT, ALL = 0, 1


@intrinsic
def take(typingctx: Any, book: Any) -> Any:
    """The number of the next ticket of a book, which becomes the one after it in the same moment."""
    if book != BOOK:
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, value=args[0]).data
        return builder.atomic_rmw("add", data, context.get_constant(types.int64, 1), "monotonic")

    return types.int64(book), emit


@intrinsic
def call(typingctx: Any, code: Any, book: Any, worker: Any) -> Any:
    """Run the code of which `address` gave the address."""

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = context.call_conv.get_function_type(types.none, sig.args[1:])
        there = builder.inttoptr(args[0], kind.as_pointer())
        context.call_conv.call_function(builder, there, types.none, sig.args[1:], args[1:])
        return context.get_dummy_value()

    return types.none(types.int64, BOOK, types.int64), emit


def share_out(code: int, book: NDArray[np.int64], workers: int) -> None:
    """Run code on so many threads, and wake none where that is one: it is given the ``workers``' numbers."""
    if workers > 1:
        on_threads(code, book, workers)
    else:
        on_this(code, book)


@parallel
def on_threads(code, book, workers):
    """`share_out` where there are several."""
    for worker in prange(workers):
        call(code, book, np.int64(worker))


@function
def on_this(code, book):
    """`share_out` by the thread that calls."""
    call(code, book, 0)


def address(function: Any) -> int:
    """Where the machine code of a compiled function of a book and a worker's number begins."""
    given = BOOK, types.int64
    function.compile(given)
    made = function.overloads[given]
    return int(made.library.get_pointer_to_function(made.fndesc.llvm_func_name))
