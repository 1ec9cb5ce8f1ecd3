"""Functions whose code follows from the types of their arguments."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from numba import config
from numba.extending import overload

from . import BARE, LEAN


def by_type(choose: Callable[..., Any], inline: bool = False, strict: bool = True) -> Any:
    """A decorator: kernels that call the function call what it returns for the types of its arguments, compiled as
    `device` or, with ``inline``, as `inlined`; ``strict``: of the same parameters."""
    options: dict[str, Any] = LEAN | BARE | {"forceinline": inline}
    return overload(choose, jit_options=options, strict=strict)(choose)  # type: ignore[arg-type]


def device_where(needed: Callable[[Any], bool], otherwise: Any) -> Any:
    """A decorator: `device` where ``needed`` of the type of the first argument is true, else ``otherwise``, a function
    of the same parameters.

    A test of a type within a function would not spare the compiler what stands behind it.
    """

    def decorate(function: Any) -> Any:
        if config.DISABLE_JIT:  # type: ignore[attr-defined]
            return function

        def choose(*types: Any) -> Any:
            return function if needed(types[0]) else otherwise

        choose.__signature__ = inspect.signature(function)  # type: ignore[attr-defined]
        overload(function, jit_options=LEAN | BARE)(choose)  # type: ignore[arg-type]
        return function

    return decorate
