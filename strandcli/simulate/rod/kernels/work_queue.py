"""Work queue: threads take one task after the other, so that none waits for a slow one.

A queue, an int64 array, has the number of the next task and the number of tasks. Numba compiles the body of a parallel
loop three times, with all functions that it calls; so that body calls compiled code by its address, with arguments that
`bind` has written down.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import intrinsic

from ....jit import function, parallel, prange

QUEUE = types.Array(types.int64, 1, "C")
NEXT, TASKS = 0, 1
"""Places of a queue."""
WORD = ir.IntType(64)


@intrinsic
def take(typingctx: Any, queue: Any) -> Any:
    """Return the number of the next task, and increment it atomically."""
    if queue != QUEUE:
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, value=args[0]).data
        return builder.atomic_rmw("add", data, context.get_constant(types.int64, 1), "monotonic")

    return types.int64(queue), emit


@intrinsic
def bind(typingctx: Any, code: Any, arguments: Any) -> Any:
    """Return two addresses: of a function that calls the code at an address with a tuple of arguments and a worker's
    number, and of what it needs, which is gone when the caller of `bind` ends."""
    if not isinstance(arguments, types.Tuple):
        return None
    kinds = [*arguments.types, types.int64]

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        record = cgutils.alloca_once_value(builder, cgutils.make_anonymous_struct(builder, args))
        name = builder.module.get_unique_name("bound")
        made = ir.Function(builder.module, ir.FunctionType(ir.VoidType(), [WORD, WORD]), name)
        made.linkage = "internal"
        inner = ir.IRBuilder(made.append_basic_block())
        there, given = cgutils.unpack_tuple(inner, inner.load(inner.inttoptr(made.args[0], record.type)))
        called = inner.inttoptr(there, context.call_conv.get_function_type(types.none, kinds).as_pointer())
        parts = [*cgutils.unpack_tuple(inner, given), made.args[1]]
        context.call_conv.call_function(inner, called, types.none, kinds, parts)
        inner.ret_void()
        return context.make_tuple(
            builder, sig.return_type, [builder.ptrtoint(made, WORD), builder.ptrtoint(record, WORD)]
        )

    return types.UniTuple(types.int64, 2)(types.int64, arguments), emit


@intrinsic
def call(typingctx: Any, caller: Any, record: Any, worker: Any) -> Any:
    """Call what `bind` has returned for a worker."""

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.FunctionType(ir.VoidType(), [WORD, WORD])
        builder.call(builder.inttoptr(args[0], kind.as_pointer()), args[1:])
        return context.get_dummy_value()

    return types.none(types.int64, types.int64, types.int64), emit


def run_workers(code: int, arguments: tuple[Any, ...], queue: Any, workers: int) -> None:
    """Run the code at an address with arguments, once for each of ``workers`` with its number, from the first task of
    the ``queue`` on; a single worker runs on the calling thread."""
    queue[NEXT] = 0
    if workers > 1:
        on_threads(code, arguments, workers)
    else:
        on_this(code, arguments)


@parallel
def on_threads(code, arguments, workers):
    """Run `run_workers` on several threads."""
    caller, record = bind(code, arguments)
    for worker in prange(workers):
        call(caller, record, np.int64(worker))


@function
def on_this(code, arguments):
    """Run `run_workers` on the calling thread."""
    caller, record = bind(code, arguments)
    call(caller, record, 0)


def address(function: Any, arguments: tuple[Any, ...]) -> int:
    """Compile a function of arguments of these types and a worker's number; return the address of its machine code."""
    signature = (*(numba.typeof(one) for one in arguments), types.int64)
    function.compile(signature)
    made = function.overloads[signature]
    return int(made.library.get_pointer_to_function(made.fndesc.llvm_func_name))
