"""Processes of strandcli's own that compile kernels into the cache, for a process that loads them from there.

Numba compiles on one thread of a process; and what makes compiling faster (`strandcli.compiling.faster`) changes Numba,
which only processes of our own may do. A worker ends when the process that started it has ended, and when it has had
nothing to do for a while. Whatever goes wrong here costs time: the process that asked compiles in place.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import pickle
import subprocess
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..common import limits
from . import folder

try:
    import fcntl
except ImportError:  # no POSIX
    fcntl = None  # type: ignore[assignment]

if TYPE_CHECKING:
    from ..scene.model import Scene

PROGRAM = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from strandcli.compiling.worker import main; main(sys.argv[2])"
)
FAILURES = 3
"""After so many workers that end unasked or kernels that are lost, every kernel is compiled in place."""
PARTS = ("strands", "surfaces", "coverage", "lines")
"""Of a frame, from its end: most of the first frame's wait is for kernels that it needs last."""
LOCKS = "claims"
"""The file whose bytes are locked."""
ALONE = (
    "the processes that compile kernels end before they are done, perhaps for want of memory: kernels are compiled one "
    "by one, which takes about twice as long"
)


class Worker:
    """One process and the pipes to it."""

    def __init__(self) -> None:
        """Start it. Raises `OSError`."""
        read = [str(one.path) for one in folder.cache.read_only]
        settings = json.dumps([str(folder.cache.path), read])
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", PROGRAM, json.dumps(sys.path), settings],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for the process that was started by hand
        )

    def send(self, *message: Any) -> None:
        """Hand it a message. Raises `OSError` where it has ended."""
        pipe = self._process.stdin
        assert pipe is not None
        pipe.write(pickle.dumps(message))
        pipe.flush()

    def answer(self) -> Any:
        """Wait for what it says. Raises `EOFError` where it has ended."""
        pipe = self._process.stdout
        assert pipe is not None
        return pickle.load(pipe)

    def stop(self) -> None:
        """End it."""
        self._process.kill()
        self._process.wait()
        self.forget()

    def forget(self) -> None:
        """Close the pipes."""
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()


class Service:
    """The worker of this process: it compiles what is asked for, and its children what will be."""

    def __init__(self) -> None:
        self.enabled = True
        """False: every kernel is compiled in place."""
        self._lock = threading.RLock()
        self._worker: Worker | None = None
        self._failures = 0
        self._process = 0
        self._pending: tuple[Any, int] | None = None

    def compile(self, function: Any, sig: Any, entry: str) -> bool:
        """Have a kernel compiled into the cache; False where this process has to do it."""
        try:
            request = pickle.dumps(sig)
        except Exception:  # types that only this process has
            return False
        file = getattr(sys.modules.get(function.__module__), "__file__", None)
        if function.__module__ == "__main__" or "<locals>" in function.__qualname__ or file is None:
            return False
        with self._lock:
            if self._pending is not None:
                self._begin_ahead(*self._pending)
            worker = self._on_demand()
            if worker is None:
                return False
            try:
                worker.send("compile", function.__module__, function.__qualname__, request, entry)
                answer = worker.answer()
            except BaseException as error:
                self._worker = None
                worker.stop()
                if not isinstance(error, Exception):
                    raise
                self._fail()
                return False
        if answer == "lost":  # the disk is full, or Numba has settings here that the worker does not know
            self._fail()
        return bool(answer == "done")

    def ahead(self, scene: Scene, threads: int | None) -> None:
        """Have the kernels of a scene's frame compiled from its end, from the first kernel on that is not in the cache;
        ``threads``: processes that may be busy at once, None for one a core."""
        with self._lock:
            self._pending = scene, limits.cores() if threads is None else threads
            if nothing_compiled():
                self._begin_ahead(*self._pending)

    def _begin_ahead(self, scene: Scene, most: int) -> None:
        self._pending = None
        children = min(limits.compilers() - 1, most - 1, len(PARTS))
        if not self._usable() or children < 1:
            return
        try:
            data = pickle.dumps(scene)
            worker = self._on_demand()
            if worker is not None:
                worker.send("ahead", data, [PARTS[number::children] for number in range(children)])
        except Exception:  # a scene with rules of this process alone
            self.stop_ahead()

    def stop_ahead(self) -> None:
        """Compile nothing more that was not asked for."""
        with self._lock, contextlib.suppress(OSError):
            self._pending = None
            if self._worker is not None and self._process == os.getpid():
                self._worker.send("stop")

    def stop(self) -> None:
        """End the worker."""
        with self._lock:
            self._pending = None
            if self._worker is not None:
                if self._process == os.getpid():
                    self._worker.stop()
                else:
                    self._worker.forget()
            self._worker = None

    def _on_demand(self) -> Worker | None:
        """The worker; None where there can be none."""
        if not self._usable():
            return None
        if self._worker is None:
            try:
                self._worker = Worker()
            except OSError:
                self._fail()
        return self._worker

    def _usable(self) -> bool:
        if self._process != os.getpid():  # the first time, or a process forked from the one that had workers
            self._process = os.getpid()
            self._worker = None
            atexit.register(self.stop)
        if not self.enabled or limits.compilers() < 1:
            return False
        return "python" in Path(sys.executable or "").name and not getattr(sys, "frozen", False)

    def _fail(self) -> None:
        self._failures += 1
        if self._failures == FAILURES:
            folder.cache.tell(ALONE)
        self.enabled = self.enabled and self._failures < FAILURES


def nothing_compiled() -> bool:
    """Whether there is no kernel anywhere, so that one will be missing; False where the folder cannot be read."""
    with contextlib.suppress(OSError), os.scandir(folder.cache.path) as entries:
        return not folder.cache.read_only and not any(entry.name.endswith(".kernel") for entry in entries)
    return False


service = Service()


class Claims:
    """Entries of the cache that this process compiles, for which others wait: locks on bytes of a file of its folder.

    The system takes them back when their owner ends, however it ends. Where it has none (some network folders) work is
    done twice.
    """

    def __init__(self) -> None:
        self._file: tuple[Path, int] | None = None
        self._locked: list[int] = []

    def take(self, folder: Path, key: bytes) -> None:
        """Wait until no other process compiles this entry, and claim it.

        Two processes that would wait for each other do not: the system refuses the second, which goes on unclaimed.
        """
        place = int.from_bytes(key[:7], "big")
        if fcntl is None or place in self._locked:
            return
        with contextlib.suppress(OSError):
            fcntl.lockf(self._open(folder), fcntl.LOCK_EX, 1, place)
            self._locked.append(place)

    def count(self) -> int:
        """How many this process has."""
        return len(self._locked)

    def release(self, count: int) -> None:
        """Give back all but the first ``count``."""
        while len(self._locked) > count:
            place = self._locked.pop()
            if fcntl is not None and self._file is not None:
                with contextlib.suppress(OSError):
                    fcntl.lockf(self._file[1], fcntl.LOCK_UN, 1, place)

    def _open(self, folder: Path) -> int:
        if self._file is None or self._file[0] != folder:
            if self._file is not None:
                os.close(self._file[1])
            handle = os.open(folder / LOCKS, os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
            self._file = folder, handle
        return self._file[1]


claims = Claims()
