"""The light that strands scatter once, by the model whose tables a kernel is given."""

from __future__ import annotations

from typing import Any

from numba.core import types
from numba.extending import overload


def highlights(work: Any, n: Any, lights: Any, i: Any, tables: Any) -> None:
    """Add the light that strands scatter once of light number i, at the first n vertices of a batch.

    Which function does so is decided when a kernel is compiled: the attribute ``highlights`` of the class of
    ``tables``, a NamedTuple of arrays. `strandcli.draw.fibre.models` says what such a function reads and writes.
    """
    raise NotImplementedError("only kernels call this")


@overload(highlights, jit_options={"nogil": True, "error_model": "numpy", "_nrt": False})
def _by_tables(work: Any, n: Any, lights: Any, i: Any, tables: Any) -> Any:
    if not isinstance(tables, types.BaseNamedTuple):
        return None
    of_model = tables.instance_class.highlights

    def chosen(work: Any, n: Any, lights: Any, i: Any, tables: Any) -> None:
        of_model(work, n, lights, i, tables)

    return chosen
