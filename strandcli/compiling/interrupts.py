"""Signals wait while a kernel is loaded.

An exception that a signal's handler raises within a destructor or a callback of LLVM's is printed and lost. So a
handler asks `interrupts.wait` first, and what it would raise is raised when the kernel is there.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager


class Interrupts:
    """Whether the main thread is where nothing may be raised."""

    def __init__(self) -> None:
        self._depth = 0
        self._waiting: BaseException | type[BaseException] | None = None

    @contextmanager
    def deferred(self) -> Iterator[None]:
        """What a handler raises waits for the end of this block; on other threads no handler runs."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1
            self._raise()

    @contextmanager
    def allowed(self) -> Iterator[None]:
        """Within `deferred`: here it may be raised after all."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        depth, self._depth = self._depth, 0
        try:
            self._raise()
            yield
        finally:
            self._depth = depth

    def wait(self, error: BaseException | type[BaseException]) -> bool:
        """Whether an exception has to wait, and then does; called by handlers of signals."""
        if self._depth == 0:
            return False
        self._waiting = error
        return True

    def _raise(self) -> None:
        if self._depth == 0 and self._waiting is not None:
            error, self._waiting = self._waiting, None
            raise error


interrupts = Interrupts()
