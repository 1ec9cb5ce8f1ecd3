"""The light that strands scatter once, by the model whose tables a kernel is given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from numba.extending import overload

ATTRIBUTE = "highlights"
"""Of a class of tables: the function that shades with them."""

Tables = TypeVar("Tables", bound=tuple[Any, ...])


def shaded_by(function: Any) -> Callable[[type[Tables]], type[Tables]]:
    """A decorator for the class of a fibre model's tables: kernels that are given such tables call this function."""

    def decorate(kind: type[Tables]) -> type[Tables]:
        setattr(kind, ATTRIBUTE, function)
        return kind

    return decorate


def highlights(work: Any, n: Any, lights: Any, i: Any, tables: Any) -> None:
    """Add the light that strands scatter once of light number i, at the first n vertices of a batch.

    Which function does so is decided when a kernel is compiled, by the class of ``tables``, a NamedTuple of arrays
    (`shaded_by`). `strandcli.draw.fibre.models` says what such a function reads and writes.
    """
    raise NotImplementedError("only kernels call this")


_options: Any = {"nogil": True, "error_model": "numpy", "_nrt": False}


@overload(highlights, jit_options=_options)
def _by_tables(work: Any, n: Any, lights: Any, i: Any, tables: Any) -> Any:
    kind = getattr(tables, "instance_class", None)
    of_model = getattr(kind, ATTRIBUTE, None)
    if of_model is None:
        return None

    def chosen(work: Any, n: Any, lights: Any, i: Any, tables: Any) -> None:
        of_model(work, n, lights, i, tables)

    return chosen
