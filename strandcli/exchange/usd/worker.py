"""The program of the process that reads and writes USD: nothing else imports Pixar's library.

It answers a request by messages, of which the last says that it is the end, or what is wrong. It ends when the process
that asks has ended, and when it has had nothing to do for a while.
"""

from __future__ import annotations

import os
import re
import resource
import select
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, BinaryIO

from .process import EndedError, Fill, Message, RefusedFileError, filler, receive, send

IDLE = 20
"""Seconds without a request after which it ends."""
TIMES, TIMES_TEXT, SPARE = 8, 50, 1 << 28
"""Memory that may be taken: so many times the size of the file, of text, which is parsed in 30, and so many bytes."""
DAMAGED = "cannot be read; it is damaged or no .usd file"
NAMESPACE = re.compile(r" matching pxr.*?(?= at |$)|pxr\w+::")


def main() -> None:
    """Answer until the other end is closed."""
    incoming, outgoing = os.fdopen(os.dup(0), "rb", 0), os.fdopen(os.dup(1), "wb", 1 << 16)
    nothing = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):  # Pixar's library prints
        os.dup2(nothing, descriptor)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
    fill = filler(incoming)
    with suppress(EndedError, BrokenPipeError):
        while select.select([incoming], [], [], IDLE)[0]:
            request, _ = receive(fill)
            send(outgoing, {"begun": True})
            _answer(request, fill, outgoing)


def _answer(request: dict[str, Any], fill: Fill, outgoing: BinaryIO) -> None:
    """Do what is asked, and say how it ended."""
    from pxr import Tf

    _limit(request)
    try:
        for header, arrays in _asked(request)(request, fill):
            send(outgoing, header, arrays)
        last: dict[str, Any] = {"end": True}
    except RefusedFileError as error:
        last = {"error": str(error)}
    except Tf.ErrorException as error:
        last = {"error": _words(error, request.get("path", ""))}
    except MemoryError:
        last = {"error": DAMAGED}
    except (EndedError, BrokenPipeError):
        raise
    except Exception as error:
        last = {"error": f"{type(error).__name__}: {error}"}
    send(outgoing, last)


def _asked(request: dict[str, Any]) -> Callable[[dict[str, Any], Fill], Iterator[Message]]:
    from . import read_cameras, read_stage, write_stage

    return {
        "read": read_stage.read, "cameras": read_cameras.read,
        "write": write_stage.write,
    }[request["do"]]  # fmt: skip


@cache
def _warm() -> None:
    """Let Pixar's library take what it takes for any file, some 400 MB of addresses, which are not the file's."""
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.BasisCurves.Define(stage, "/a").CreatePointsAttr([(0, 0, 0), (0, 1, 0)])


def _limit(request: dict[str, Any]) -> None:
    """Let files that are read take no more memory than is right for their size; what is written is trusted."""
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    limit = hard
    if request["do"] != "write":
        _warm()
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        limit = used + (TIMES_TEXT if request["text"] else TIMES) * request["bytes"] + SPARE
        limit = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


def _words(error: Any, path: str) -> str:
    """What Pixar's library says of an error, without its own places."""
    try:
        words = " ".join(str(getattr(error.args[0], "commentary", error.args[0])).split())
    except (IndexError, UnicodeDecodeError):  # it says what is in the file, be it text or not
        return DAMAGED
    if "bad_alloc" in words or "max_size" in words:
        return DAMAGED
    words = NAMESPACE.sub("", words.replace(path, "").replace(", while reading @@", "")).lstrip(": ").rstrip(". ")
    return f"{words}; it is damaged or no .usd file"
