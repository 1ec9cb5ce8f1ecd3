"""Which process compiles an entry of the cache: the first that claims it; the others wait and load it.

A claim is a lock on one byte of a file of the cache folder, which the system takes back when its owner ends, however
it ends. Locks belong to processes, so that a system without them (some network folders) costs double work, not more.
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

try:
    import fcntl
except ImportError:  # no POSIX
    fcntl = None  # type: ignore[assignment]

NAME = "claims"


class Claims:
    """The claims of this process in one folder."""

    def __init__(self) -> None:
        self._file: tuple[Path, int] | None = None
        self._held: list[int] = []

    def take(self, folder: Path, key: bytes) -> None:
        """Wait until no other process compiles this entry, and claim it.

        Two processes that would wait for each other do not: the system refuses the second, which goes on unclaimed.
        """
        place = int.from_bytes(key[:7], "big")
        if fcntl is None or place in self._held:
            return
        with contextlib.suppress(OSError):
            fcntl.lockf(self._open(folder), fcntl.LOCK_EX, 1, place)
            self._held.append(place)

    def count(self) -> int:
        """How many this process has."""
        return len(self._held)

    def release(self, count: int) -> None:
        """Give back all but the first ``count``."""
        while len(self._held) > count:
            place = self._held.pop()
            if fcntl is not None and self._file is not None:
                with contextlib.suppress(OSError):
                    fcntl.lockf(self._file[1], fcntl.LOCK_UN, 1, place)

    def _open(self, folder: Path) -> int:
        if self._file is None or self._file[0] != folder:
            if self._file is not None:
                os.close(self._file[1])
            handle = os.open(folder / NAME, os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
            self._file = folder, handle
        return self._file[1]


claims = Claims()
