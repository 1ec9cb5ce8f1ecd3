"""The process that reads and writes USD: begun when it is needed, asked, and ended where it does not answer; and
messages between two processes: what is said as JSON, and arrays behind it."""

from __future__ import annotations

import atexit
import contextlib
import importlib.util
import io
import json
import math
import os
import select
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from ...common.extras import install
from ...errors import RefusedError, StrandError, UsageError
from ...files.inputs import note
from ..bounded import amount, shortened
from ..written import raw

PROGRAM = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from strandcli.exchange.usd.worker import main; main()"
)
SECONDS, BYTES_A_SECOND = 60.0, 1e6
"""How long an answer may take: so long, and a second more for so many bytes of the file."""
SPARE = 1 << 26
"""Bytes of arrays that are taken from a file beyond three times its size."""
KEPT = 1 << 25
"""Bytes of arrays in an answer up to which the process waits for the next file: beside more of them its own memory is
missed, and the second that the next one takes to begin is little; but not for each moment of a file that moves."""
ENVIRONMENT = {"PXR_WORK_THREAD_LIMIT": "1", "MALLOC_ARENA_MAX": "1"}
"""Threads of Pixar's library would each take memory of their own."""
SIZE = struct.Struct("<Q")
"""Bytes of the JSON, before it."""
LONGEST_JSON = 1 << 26
"""Bytes of the JSON, at most."""

Fill = Callable[[memoryview], None]
"""Fills memory with the bytes that come next."""
Message = tuple[dict[str, Any], list[npt.NDArray[Any]]]


class RefusedFileError(Exception):
    """A file is none that can be read; the message says why."""


def send(stream: BinaryIO, header: dict[str, Any], arrays: Sequence[npt.NDArray[Any]] = ()) -> None:
    """Send a message. Raises `OSError` where the other end is closed."""
    text = json.dumps({**header, "arrays": [[one.dtype.str, list(one.shape)] for one in arrays]}).encode()
    stream.write(SIZE.pack(len(text)) + text)
    for one in arrays:
        if one.size:
            stream.write(raw(one, one.dtype.str))
    stream.flush()


def receive(fill: Fill, room: int | None = None) -> Message:
    """The next message and its arrays, for which at most ``room`` bytes are taken. Raises what ``fill`` does, and
    `OverflowError` for more."""
    head = bytearray(SIZE.size)
    fill(memoryview(head))
    size = SIZE.unpack(head)[0]
    if size > LONGEST_JSON:
        raise OverflowError
    text = bytearray(size)
    fill(memoryview(text))
    header: dict[str, Any] = json.loads(bytes(text))
    arrays = []
    for kind, shape in header.pop("arrays"):
        dtype = np.dtype(kind)
        needs = math.prod(shape) * dtype.itemsize
        if room is not None:
            if needs > room:
                raise OverflowError
            room -= needs
        values = np.empty(shape, dtype)
        if values.size:
            fill(values.reshape(-1).view(np.uint8).data)
        arrays.append(values)
    return header, arrays


class EndedError(Exception):
    """The process has ended, or takes too long."""


def filler(pipe: Any, comes: Callable[[], bool] = lambda: True) -> Fill:
    """Fills memory with what comes through a pipe, and raises `EndedError` where that ends; ``comes``: waits for
    more, and says whether there is any."""

    def fill(view: memoryview) -> None:
        done = 0
        while done < len(view):
            got = pipe.readinto(view[done:]) if comes() else 0
            if not got:
                raise EndedError
            done += got

    return fill


class Process:
    """The process, and the pipes to it."""

    def __init__(self) -> None:
        """Start it. Raises `OSError`."""
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-c", PROGRAM, json.dumps(sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            bufsize=0,
            env={**os.environ, **ENVIRONMENT},
            start_new_session=True,  # Ctrl-C is for the process that was started by hand
        )
        self.stdin = io.BufferedWriter(self.process.stdin)  # type: ignore[type-var]
        self.deadline = float("inf")

    def send(self, header: dict[str, Any], arrays: Sequence[npt.NDArray[Any]] = ()) -> None:
        """Hand it a message. Raises `EndedError`."""
        try:
            send(self.stdin, header, arrays)
        except OSError:
            raise EndedError from None

    def answer(self, room: int) -> Message:
        """What it says next, whose arrays take ``room`` bytes at most. Raises `EndedError`, `OverflowError`."""
        return receive(filler(self.process.stdout, self._in_time), room)

    def _in_time(self) -> bool:
        pipe: Any = self.process.stdout
        left = self.deadline - time.monotonic()
        return left > 0 and bool(select.select([pipe], [], [], min(left, 1e6))[0])

    def stop(self) -> int:
        """End it; returns what it ended with."""
        self.process.kill()
        code = self.process.wait()
        for pipe in (self.stdin, self.process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()
        return code


_idle: list[Process] = []
"""The process that waits for the next file."""


@atexit.register
def _stop_idle() -> None:
    while _idle:
        _idle.pop().stop()


def ask(path: Path, header: dict[str, Any], more: Iterator[Message] | None = None) -> Iterator[Message]:
    """What the process answers about a file: messages, each as soon as it is there. ``more``: messages that are sent
    after the first one, of which none is answered before the last.

    Raises `UsageError` for what is no USD, or too much of it, and for want of Pixar's library; `RefusedError` for what
    cannot be written.
    """
    if importlib.util.find_spec("pxr") is None:
        raise UsageError(f"{path}: USD is read and written with Pixar's library: {install('usd')}")
    size = 0
    with contextlib.suppress(OSError):
        size = path.stat().st_size
    process = _begun(path, {**header, "bytes": size})
    done, moves, taken = False, False, 0
    try:
        for message in more or ():
            process.send(*message)
        process.deadline = time.monotonic() + SECONDS + size / BYTES_A_SECOND
        while True:
            found, arrays = process.answer(3 * size + SPARE)
            if found.get("end"):
                done = True
                return
            if "error" in found:
                done = True
                raise _error(path, header["do"], found["error"])
            process.deadline = float("inf")  # what asks may take its time
            taken += sum(one.nbytes for one in arrays)
            moves = moves or len(found.get("times", ())) > 1
            for layer in found.get("layers", ()):
                note(layer)
            yield found, arrays
            process.deadline = time.monotonic() + SECONDS + size / BYTES_A_SECOND
    except OverflowError:
        raise UsageError(f"{path}: declares more than can be in a file of {amount(size)}; it is damaged") from None
    except EndedError:
        raise _error(path, header["do"], "crashes Pixar's library, or takes it too long; it is damaged") from None
    finally:
        if done and not _idle and (moves or taken <= KEPT):
            process.deadline = float("inf")
            _idle.append(process)
        else:
            process.stop()


def _begun(path: Path, header: dict[str, Any]) -> Process:
    """A process that has the request: the one that waits if it still does, else a new one."""
    while True:
        waits, process = bool(_idle), None
        try:
            process = _idle.pop() if waits else Process()
            process.send(header)
            process.deadline = time.monotonic() + SECONDS
            process.answer(0)
            return process
        except (OSError, EndedError, OverflowError):
            if process is not None:
                process.stop()
            if not waits:
                raise RefusedError(f"{path}: the process that reads and writes USD cannot be started") from None


def _error(path: Path, do: str, words: str) -> StrandError:
    words = shortened(words)
    return RefusedError(f"{path}: cannot be written: {words}") if do == "write" else UsageError(f"{path}: {words}")
