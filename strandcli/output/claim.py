"""Which files of a folder a run is writing: two runs that write the same ones at once would mix two films.

A claim is a lock on bytes of a hidden file, a byte a frame, so that several runs, on several machines that share the
folder too, may each write frames of their own. The system lets go of it when its process ends, however: a file
that a killed run has left claims nothing. Where a file system has no locks, nothing is claimed and nothing refused.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from ..errors import RefusedError

try:
    import fcntl
except ImportError:  # no POSIX
    fcntl = None  # type: ignore[assignment]

_ALL = (0, 0)
"""First byte of a lock, and how many: on a whole file."""
_PATIENCE = 0.15
"""Seconds: a run that ends holds the whole file while it removes it."""
_PAUSE = 0.05


class Claim:
    """A hold on some files of a folder, until `release` or the end of the process; not against this process itself."""

    def __init__(
        self, directory: Path, what: str, numbers: Iterable[int] | None = None, patience: float = _PATIENCE
    ) -> None:
        """Claim the files called ``what`` ("frames") with these numbers, None: all of them, in a folder that is there.

        Raises ``RefusedError`` where another run has claimed one of them and does not let go within ``patience``
        seconds.
        """
        self._path, self._file = directory / f".{what}.lock", -1
        spans = [_ALL] if numbers is None else _spans(numbers)
        deadline = time.monotonic() + patience
        while spans and fcntl is not None and self._file < 0:
            try:
                self._file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o666)
                for span in spans:
                    _hold(self._file, span)
            except BlockingIOError:
                self._close()
                if time.monotonic() >= deadline:
                    raise RefusedError(
                        f"{directory}: another run is writing the same {what} there just now; wait until it has ended, "
                        "or choose another folder with -o"
                    ) from None
                time.sleep(_PAUSE)
            except OSError:  # no locks on this file system, or a file of another user's
                self._close()
                return

    def release(self) -> None:
        """Let go, and remove the file where no other process has a part of it."""
        if self._file >= 0:
            with suppress(OSError):
                _hold(self._file, _ALL)
                self._path.unlink()
            self._close()

    def _close(self) -> None:
        if self._file >= 0:
            os.close(self._file)
        self._file = -1


def _spans(numbers: Iterable[int]) -> list[tuple[int, int]]:
    """First and count of each run of numbers."""
    spans: list[tuple[int, int]] = []
    for number in sorted(numbers):
        if spans and sum(spans[-1]) == number:
            spans[-1] = spans[-1][0], spans[-1][1] + 1
        else:
            spans.append((number, 1))
    return spans


def _hold(file: int, span: tuple[int, int]) -> None:
    first, count = span
    fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, count, first)
