"""A compiled function of strandcli's, with a cache of its own: Numba's dispatcher and settings stay as they are."""

from __future__ import annotations

import functools
import threading
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
        with clock.call(self._cache.name), interrupts.deferred(), self._cache.claims():
            return super().compile(sig)


_making = threading.RLock()


class Deferred:
    """A function that only kernels call. It stands for a dispatcher wherever Numba meets it in the text of a kernel,
    and makes that when a kernel is compiled that calls it: there are eight hundred, of a fifteenth of a millisecond
    each, and a kernel that comes from the cache has its code already."""

    def __init__(self, function: Any, decorate: Any) -> None:
        """``decorate``: makes the dispatcher of the function."""
        functools.update_wrapper(self, function)  # type: ignore[arg-type]
        self.py_func = function
        self._decorate = decorate
        self._made: Any = None

    @property
    def _numba_type_(self) -> Any:
        """The type of the dispatcher, which Numba asks for."""
        return self._dispatcher()._numba_type_

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._dispatcher(), name)

    def _dispatcher(self) -> Any:
        with _making:
            if self._made is None:
                self._made = self._decorate(self.py_func)
            return self._made
