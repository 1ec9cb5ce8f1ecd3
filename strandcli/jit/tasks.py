"""Tasks that threads take from a queue, one after the other, so that none waits for a slow one.

A queue, an int64 array, has the number of the next task, the number of tasks, and that of the phase they belong to.
Numba compiles the body of a parallel loop three times, with all functions that it calls, and each loop anew; so all
tasks have one loop, which calls compiled code by its address, with arguments that were written down before.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import intrinsic

from . import function, parallel, prange

QUEUE = types.Array(types.int64, 1, "C")
NEXT, TASKS, PHASE = 0, 1, 2
"""Places of a queue."""
WORD = ir.IntType(64)
WORDS = 4096
"""That there is room for to write arguments down."""
CALLER = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64)


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
def write_down(typingctx: Any, code: Any, arguments: Any, record: Any) -> Any:
    """Write the address of code and a tuple of arguments to a record, `WORDS` int64; return the address of a function
    that is handed the record's and a worker's number, and calls the code with the arguments and that number."""
    if not isinstance(arguments, types.Tuple):
        return None
    kinds = [*arguments.types, types.int64]

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        given = cgutils.make_anonymous_struct(builder, args[:2])
        assert context.get_abi_sizeof(given.type) <= 8 * WORDS
        data = context.make_array(sig.args[2])(context, builder, value=args[2]).data
        place = builder.bitcast(data, given.type.as_pointer())
        builder.store(given, place)
        name = builder.module.get_unique_name("bound")
        made = ir.Function(builder.module, ir.FunctionType(ir.VoidType(), [WORD, WORD]), name)
        made.linkage = "internal"
        inner = ir.IRBuilder(made.append_basic_block())
        there, given = cgutils.unpack_tuple(inner, inner.load(inner.inttoptr(made.args[0], place.type)))
        called = inner.inttoptr(there, context.call_conv.get_function_type(types.none, kinds).as_pointer())
        parts = [*cgutils.unpack_tuple(inner, given), made.args[1]]
        context.call_conv.call_function(inner, called, types.none, kinds, parts)
        inner.ret_void()
        return builder.ptrtoint(made, WORD)

    return types.int64(types.int64, arguments, QUEUE), emit


@function
def bind(code: Any, arguments: Any, record: Any) -> Any:
    """`write_down`."""
    return write_down(code, arguments, record)  # type: ignore[call-arg]


@intrinsic
def call(typingctx: Any, caller: Any, record: Any, worker: Any) -> Any:
    """Call what `write_down` has returned, of a record at an address, for a worker."""

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.FunctionType(ir.VoidType(), [WORD, WORD])
        builder.call(builder.inttoptr(args[0], kind.as_pointer()), args[1:])
        return context.get_dummy_value()

    return types.none(types.int64, types.int64, types.int64), emit


@parallel
def on_threads(caller: Any, record: Any, workers: Any) -> None:
    """`call` for so many workers, each on a thread."""
    for worker in prange(workers):
        call(caller, record, np.int64(worker))  # type: ignore[call-arg]


class Tasks:
    """Runs a compiled function for tasks. It is handed the arguments, a queue and a worker's number, and takes tasks
    from the queue until there are none left. Arguments always have the same types."""

    def __init__(self, function: Any) -> None:
        self._function = function
        self._code = self._caller = 0
        self._given: tuple[Any, ...] = ()
        self._queue, self._record = np.zeros(3, np.int64), np.empty(WORDS, np.int64)
        self._at = self._record.ctypes.data

    def bind(self, arguments: tuple[Any, ...]) -> None:
        """Take the arguments of the tasks that come next. They are read when these are run, and must live till then."""
        given = self._given = (*arguments, self._queue)
        if not self._code:  # compiled no sooner than anything moves, which need not be
            self._code = address(self._function, given)
        self._caller = bind(self._code, given, self._record)

    def run(self, tasks: int, workers: int, phase: int = 0) -> None:
        """Run so many tasks by ``workers``; a single one works on the calling thread."""
        self._queue[:] = 0, tasks, phase
        if workers > 1:
            on_threads(self._caller, self._at, workers)
        else:
            CALLER(self._caller)(self._at, 0)


def address(function: Any, arguments: tuple[Any, ...]) -> int:
    """Compile a function of arguments of these types and a worker's number; return the address of its machine code."""
    signature = (*(numba.typeof(one) for one in arguments), types.int64)
    function.compile(signature)
    made = function.overloads[signature]
    return int(made.library.get_pointer_to_function(made.fndesc.llvm_func_name))
