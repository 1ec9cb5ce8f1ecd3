"""The decorators with which this package compiles functions.

No fastmath: without it the bits are the same on every thread count, and it gained at most a sixth.
"""

from typing import Any

from numba import config, njit, prange

from .dispatcher import Deferred, KernelDispatcher

__all__ = ["device", "function", "inlined", "parallel", "prange"]


def _cached(**options: Any) -> Any:
    """A decorator that compiles with these options and keeps what was compiled in strandcli's own cache."""

    def decorate(function: Any) -> Any:
        return function if config.DISABLE_JIT else KernelDispatcher(function, options)  # type: ignore[attr-defined]

    return decorate


def _uncached(**options: Any) -> Any:
    """A decorator of functions that are compiled with these options into each kernel that calls them."""
    decorate = njit(**options)
    return lambda function: function if config.DISABLE_JIT else Deferred(function, decorate)  # type: ignore[attr-defined]


_no_wrapper: dict[str, Any] = {"no_cfunc_wrapper": True}
parallel: Any = _cached(parallel=True, nogil=True, error_model="numpy", **_no_wrapper)
"""A kernel that a driver calls: its loops run on all threads."""

# without a value of its own, a function would inherit `forceinline` from whichever happens to have it compiled first
LEAN: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": False, "forceinline": False}
function: Any = _cached(**LEAN, **_no_wrapper)
"""A function that kernels call. Here and below references to arrays are not counted, which may take an atomic step for
each array and call: the kernel keeps them. So kernels alone take memory, and hand it on; a function may return an array
in a tuple, but only one that it was given."""

BARE: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
device: Any = _uncached(**LEAN, **BARE)
"""A function that only kernels call, each of which holds a copy: without the wrappers for Python, which take a tenth of
a second each, without machine code, and not cached."""

inlined: Any = _uncached(**LEAN | BARE | {"forceinline": True})
"""A function that is part of whichever calls it: for small ones that are handed much, which calls would write down."""
