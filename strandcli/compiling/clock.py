"""The seconds that a process has waited for kernels to be compiled.

Counted by strandcli's own dispatchers: Numba's events would tell of every function of the process.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Notify = Callable[[str], None]


class Clock:
    """Adds up compile time; a kernel compiled while another is compiled counts once, each thread for itself."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self.notify: Notify | None = None
        """Is handed a line of text each time that compiling begins."""
        self._thread = threading.local()

    @contextmanager
    def call(self) -> Iterator[None]:
        """A dispatcher looks for a kernel; the time counts from `missed` on, if that is called."""
        mine = self._thread
        mine.depth = getattr(mine, "depth", 0) + 1
        try:
            yield
        finally:
            mine.depth -= 1
            if mine.depth == 0:
                self._stop()

    def missed(self, name: str) -> None:
        """The kernel is not in the cache: compiling begins."""
        mine = self._thread
        if getattr(mine, "depth", 0) > 0 and getattr(mine, "began", None) is None:
            mine.began = time.perf_counter()
            self.tell(f"compiling {name}")

    def tell(self, words: str) -> None:
        """Hand ``words`` to `notify`."""
        if self.notify is not None:
            self.notify(words)

    def _stop(self) -> None:
        began = getattr(self._thread, "began", None)
        if began is not None:
            self.seconds += time.perf_counter() - began
            self._thread.began = None


clock = Clock()
