"""Work handed out to threads as they come for it, so that none waits for one that began late or has more to do."""

from __future__ import annotations

from typing import Any

from numba.core import types
from numba.core.extending import intrinsic


@intrinsic
def take(typingctx: Any, counter: Any) -> Any:
    """The number in ``counter``, an int64 array of one, which becomes the next one in the same moment."""
    if not (isinstance(counter, types.Array) and counter.dtype == types.int64):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, value=args[0]).data
        return builder.atomic_rmw("add", data, context.get_constant(types.int64, 1), "monotonic")

    return types.int64(counter), emit
