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
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO

IDLE = 20.0
"""Seconds without work after which it ends: what it has imported takes 200 MB."""


def main(settings: str) -> None:
    """Do what comes in on standard input until that ends. ``settings``: the cache's folder, what is read beside it,
    and whether to import all that draws and simulates at once, as JSON."""
    inbound, outbound = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):  # modules that are imported may print
        os.dup2(nowhere, stream)
    os.environ.pop("NUMBA_NUM_THREADS", None)
    messages: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(inbound, messages), daemon=True).start()
    path, read_only, preload = json.loads(settings)

    from .folder import cache
    from .service import service

    cache.use(Path(path), read_only)
    service.enabled = False
    sys.meta_path.append(WrittenModules())
    import numba

    from . import faster

    faster.patch()
    numba.set_num_threads(1)
    if preload:
        from ..draw import renderer  # noqa: F401
        from ..run import pipeline  # noqa: F401
    while True:
        try:
            message = messages.get(timeout=IDLE)
        except queue.Empty:
            os._exit(0)
        if message[0] == "ahead":
            _ahead(*message[1:])
        else:
            pickle.dump(_compile(*message[1:]), outbound)
            outbound.flush()


def _listen(inbound: BinaryIO, messages: queue.SimpleQueue[Any]) -> None:
    """Queue what comes in; end this process at once when the other one has ended."""
    try:
        while True:
            messages.put(pickle.load(inbound))
    finally:
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
    from ..draw.compile_parts import compile_part
    from ..draw.renderer import Renderer
    from ..groom.emit import emit

    with contextlib.suppress(Exception):
        scene = pickle.loads(data)
        small = dataclasses.replace(scene, image=dataclasses.replace(scene.image, size=(8, 8)))
        renderer = Renderer(small, emit(scene.emitter, scene.seed, 1))
        for part in parts:
            compile_part(renderer, part)
