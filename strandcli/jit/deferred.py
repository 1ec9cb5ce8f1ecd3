"""A function that only kernels call, without its dispatcher until a kernel is compiled that calls it.

There are eight hundred of them. Numba's dispatcher of one takes a fifteenth of a millisecond to make, and a kernel that
comes from the cache has its code already.
"""

from __future__ import annotations

import functools
import threading
from typing import Any

_making = threading.RLock()


class Deferred:
    """Stands for a dispatcher wherever Numba meets it in the text of a kernel."""

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
