"""Ctrl-C and SIGTERM: both end a run in good order, with the exit codes 130 and 143."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from ..errors import INTERRUPTED, TERMINATED


class Terminated(KeyboardInterrupt):
    """SIGTERM came in. A kind of ``KeyboardInterrupt``, so that whatever tidies up after one does so after both."""


_received: type[KeyboardInterrupt] | None = None
_when = 0.0
_IMPATIENT = 1.0


@contextmanager
def handled() -> Iterator[None]:
    """Take over SIGINT and SIGTERM for a block, if this is the main thread (Python allows it nowhere else)."""
    global _received
    _received = None
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, _handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _handle(number: int, frame: FrameType | None) -> None:
    """Raise once. While that run tidies up, the same signal again within a second is the same keystroke; later it
    means that the person has had enough."""
    global _received, _when
    now = time.monotonic()
    if _received is not None:
        if now - _when > _IMPATIENT:
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
        return
    _received = Terminated if number == signal.SIGTERM else KeyboardInterrupt
    _when = now
    raise _received


def check() -> None:
    """Raise again what came in, if it was swallowed on its way (an exception inside a destructor is only printed)."""
    if _received is not None:
        raise _received


def exit_code(error: BaseException | None) -> int:
    """130, or 143 for a ``Terminated``."""
    return TERMINATED if isinstance(error, Terminated) else INTERRUPTED
