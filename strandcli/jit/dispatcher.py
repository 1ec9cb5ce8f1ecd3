"""A compiled function of strandcli's, with a cache of its own: Numba's dispatcher and settings stay as they are."""

from __future__ import annotations

from typing import Any

from numba.core.registry import CPUDispatcher

from ..compiling.clock import clock
from ..compiling.interrupts import interrupts
from .cache import KernelCache


class KernelDispatcher(CPUDispatcher):
    """Compiles or loads one function, a kernel for each signature."""

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        """``options``: as `numba.njit` takes them."""
        targetoptions = {"nopython": True, "boundscheck": None, **options}
        super().__init__(py_func=function, locals={}, targetoptions=targetoptions)
        self._cache = KernelCache(function, options)

    def compile(self, sig: Any) -> Any:
        """The entry point for a signature, from memory, from the cache or from the compiler."""
        with clock.call(self._cache.name), interrupts.held(), self._cache.claims():
            return super().compile(sig)
