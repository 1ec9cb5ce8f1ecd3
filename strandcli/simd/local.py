"""Small arrays on a function's own stack, for kernels that must not take memory.

nodes = local_int32()       `PLACES` numbers of any value, gone when the function that asks for them ends
distances = local_float64()
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import intrinsic

PLACES = 96
"""Numbers in such an array."""


def _local(dtype: Any) -> Any:
    def typed(typingctx: Any) -> Any:
        def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            from numba.np.arrayobj import make_array, populate_array

            kind = context.get_value_type(dtype)
            # in the function's first block, so that a call within a loop takes no more at each turn
            data = cgutils.alloca_once(builder, kind, size=ir.Constant(ir.IntType(64), PLACES))
            places, size = (context.get_constant(types.intp, n) for n in (PLACES, context.get_abi_sizeof(kind)))
            whole = make_array(sig.return_type)(context, builder)
            populate_array(whole, data, [places], [size], size, None)
            return whole._getvalue()

        return types.Array(dtype, 1, "C")(), emit

    return intrinsic(typed)


local_int32 = _local(types.int32)
local_float64 = _local(types.float64)
