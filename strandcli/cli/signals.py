"""Ctrl-C, SIGTERM and SIGHUP (the terminal is closed) end a run in good order, with the exit codes 130, 143 and 129."""

from __future__ import annotations

import atexit
import os
import signal
import stat
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from ..compiling.interrupts import interrupts
from ..errors import HUNG_UP, INTERRUPTED, TERMINATED


class Terminated(KeyboardInterrupt):
    """SIGTERM came in. A kind of ``KeyboardInterrupt``, so that whatever tidies up after one does so after all."""


class HungUp(KeyboardInterrupt):
    """SIGHUP came in."""


SIGHUP: int = getattr(signal, "SIGHUP", -1)
"""Windows has no such signal."""
_RAISED: dict[int, type[KeyboardInterrupt]] = {
    signal.SIGINT: KeyboardInterrupt, signal.SIGTERM: Terminated, SIGHUP: HungUp
}  # fmt: skip
_received: type[KeyboardInterrupt] | None = None
_when = 0.0
_IMPATIENT = 1.0


@contextmanager
def handled(last: bool = False) -> Iterator[None]:
    """Take over these signals for a block, if this is the main thread (Python allows it nowhere else).

    With ``last`` the process ends after the block, and they are not given back: Python's own handler would raise amid
    what runs at its exit.
    """
    global _received, _when
    _received = None
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    # nohup has SIGHUP ignored, and means it
    mine: list[int] = [one for one in _RAISED if one > 0 and (one != SIGHUP or signal.getsignal(one) != signal.SIG_IGN)]
    before = {number: signal.signal(number, _handle) for number in mine}
    try:
        yield
    finally:
        if not last:
            for number, handler in before.items():
                signal.signal(number, handler)
        else:
            if _received is None:  # too late to interrupt anything
                _received, _when = KeyboardInterrupt, time.monotonic()
            atexit.register(_ignore, mine)  # by when threads have ended


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
    _received = _RAISED[number]
    _when = now
    if number == SIGHUP:
        _leave_terminal()
    if not interrupts.wait(_received):
        raise _received


def _ignore(numbers: list[int]) -> None:
    """For Python's last moments, in which it has no handlers: the exit code stays what it is."""
    for number in numbers:
        signal.signal(number, signal.SIG_IGN)


def _leave_terminal() -> None:
    """Have what is printed go nowhere: to write to a terminal that is closed is an error."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        try:
            if stat.S_ISCHR(os.fstat(stream).st_mode):
                os.dup2(nowhere, stream)
        except OSError:  # nothing is open there
            continue
    os.close(nowhere)


def check() -> None:
    """Raise again what came in, if it was swallowed on its way (an exception inside a destructor is only printed)."""
    if _received is not None:
        raise _received


def exit_code(error: BaseException | None) -> int:
    """130, or 143 for a ``Terminated`` and 129 for a ``HungUp``."""
    return TERMINATED if isinstance(error, Terminated) else HUNG_UP if isinstance(error, HungUp) else INTERRUPTED
