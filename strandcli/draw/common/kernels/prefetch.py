"""Memory asked for before it is needed: a place that nobody has read lately takes as long as a hundred steps."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.cgutils import get_or_insert_function
from numba.core.extending import intrinsic

READ, KEPT, DATA = 0, 3, 1
"""For reading, to stay in all caches, data and not code."""


@intrinsic
def prefetch(_: Any, array: Any, index: Any) -> Any:
    """Ask for the cache line that holds the number of this index in a contiguous array, all its axes counted as one. A
    place that is none does no harm."""

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        place = builder.bitcast(builder.gep(data, [args[1]]), ir.IntType(8).as_pointer())
        number = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [place.type, number, number, number])
        ask = get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
        builder.call(ask, [place, number(READ), number(KEPT), number(DATA)])
        return context.get_dummy_value()

    return types.void(array, index), emit
