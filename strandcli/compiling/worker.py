"""A process that compiles kernels into the cache for the one that has started it (`strandcli.compiling.service`)."""

from __future__ import annotations

import contextlib
import dataclasses
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import json
import os
import pickle
import queue
import signal
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO, NoReturn

IDLE = 20.0
"""Seconds without work after which it ends: what it has imported takes 200 MB."""


def main(settings: str) -> None:
    """Do what comes in on standard input until that ends. ``settings``: the cache's folder, and what is read beside it,
    as JSON."""
    inbound, outbound = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):  # modules that are imported may print
        os.dup2(nowhere, stream)
    os.environ.pop("NUMBA_NUM_THREADS", None)
    messages: queue.SimpleQueue[Any] = queue.SimpleQueue()
    children = Children()
    threading.Thread(target=_listen, args=(inbound, messages, children), daemon=True).start()
    path, read_only = json.loads(settings)

    from .folder import cache
    from .service import service

    cache.use(Path(path), read_only)
    service.enabled = False
    sys.meta_path.append(WrittenModules())
    from . import faster

    faster.patch()
    while True:
        try:
            message = messages.get(timeout=IDLE)
        except queue.Empty:
            if not children.busy():
                os._exit(0)
            continue
        if message[0] == "ahead":
            with contextlib.suppress(OSError):  # no process more, or no memory
                children.start(*message[1:])
        else:
            pickle.dump(_compile(*message[1:]), outbound)
            outbound.flush()


def _listen(inbound: BinaryIO, messages: queue.SimpleQueue[Any], children: Children) -> None:
    """Queue what comes in; stop children when that is asked for, and end this process at once when the other one has
    ended."""
    try:
        while True:
            message = pickle.load(inbound)
            if message[0] == "stop":
                children.stop()
            else:
                messages.put(message)
    finally:
        os._exit(0)


class Children:
    """Processes forked from this one, once it has imported what they need, that compile parts of a scene's frame."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._running: list[int] = []
        self._ends, self._end = os.pipe()
        """Reading from the first ends when this process has."""

    def start(self, data: bytes, parts: Sequence[Sequence[str]]) -> None:
        """Start one for each list of parts, where the system can fork."""
        if not hasattr(os, "fork"):
            return
        import numba  # noqa: F401  # whose threads must not have been started

        from ..draw import compile_parts  # noqa: F401
        from ..run import pipeline  # noqa: F401

        with self._lock:
            for mine in parts:
                child = os.fork()
                if child == 0:
                    self._be_child(data, mine)
                self._running.append(child)

    def busy(self) -> bool:
        """Whether one has not ended yet."""
        with self._lock:
            self._running = [one for one in self._running if os.waitpid(one, os.WNOHANG) == (0, 0)]
            return bool(self._running)

    def stop(self) -> None:
        """End them all."""
        with self._lock:
            for child in self._running:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
            self._running.clear()

    def _be_child(self, data: bytes, parts: Sequence[str]) -> NoReturn:
        try:
            os.close(self._end)
            threading.Thread(target=self._end_with_parent, daemon=True).start()
            _ahead(data, parts)
        finally:
            os._exit(0)

    def _end_with_parent(self) -> None:
        os.read(self._ends, 1)
        os._exit(0)


def _compile(module: str, name: str, signature: bytes, entry: str) -> str:
    """Compile a kernel; returns "done", "failed", or "lost" where the entry meant is not in the cache afterwards."""
    from .folder import cache

    try:
        found: Any = importlib.import_module(module)
        for part in name.split("."):
            found = getattr(found, part)
        found.compile(pickle.loads(signature))
    except Exception:  # whoever asked for it compiles it in place and sees what is wrong
        return "failed"
    return "done" if (cache.path / entry).is_file() else "lost"


class WrittenModules(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports modules that are written into the cache's folder by their names, for kernels are made of them and
    signatures name them; one whose hash is not that in its name is refused."""

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> importlib.machinery.ModuleSpec | None:
        from .folder import cache

        file = cache.path / f"{fullname}.py"
        if path is not None or not file.is_file():
            return None
        return importlib.util.spec_from_file_location(fullname, file, loader=self)

    def exec_module(self, module: Any) -> None:
        from .folder import text_hash

        text = Path(module.__file__).read_bytes()
        if not module.__name__.endswith(text_hash(text)):
            raise ImportError(f"{module.__file__}: its content is not what was written")
        exec(compile(text, module.__file__, "exec"), module.__dict__)


def _ahead(data: bytes, parts: Sequence[str]) -> None:
    """Compile the kernels of a scene's parts. Whatever goes wrong costs time, nothing else."""
    import numba

    from ..draw.compile_parts import compile_part
    from ..draw.renderer import Renderer
    from ..groom.emit import emit

    with contextlib.suppress(Exception):
        numba.set_num_threads(min(2, numba.config.NUMBA_NUM_THREADS))  # type: ignore[attr-defined]  # one leaves out a kernel
        scene = pickle.loads(data)
        small = dataclasses.replace(scene, image=dataclasses.replace(scene.image, size=(8, 8)))
        renderer = Renderer(small, emit(scene.emitter, scene.seed, 1))
        for part in parts:
            compile_part(renderer, part)
