"""A process that compiles kernels into the cache for the one that has started it (`strandcli.compiling.service`)."""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import pickle
import queue
import sys
import threading
from pathlib import Path
from typing import Any, BinaryIO

IDLE = 20.0
"""Seconds without work after which it ends: what it has imported takes 200 MB."""


def main(settings: str) -> None:
    """Do what comes in on standard input until that ends. ``settings``: the cache's folder and whether to import all
    that draws and simulates at once, as JSON."""
    inbound, outbound = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):  # modules that are imported may print
        os.dup2(nowhere, stream)
    os.environ.pop("NUMBA_NUM_THREADS", None)
    messages: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(inbound, messages), daemon=True).start()
    path, preload = json.loads(settings)

    from .folder import cache
    from .service import service

    cache.use(Path(path))
    service.enabled = False
    import numba

    from . import faster

    faster.patch()
    numba.set_num_threads(1)
    if preload:
        for name in ("pipeline", "draw.renderer"):
            importlib.import_module(f"strandcli.{name}")
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


def _compile(module: str, file: str, name: str, signature: bytes, entry: str) -> str:
    """Compile a kernel; returns "done", "failed", or "lost" where the entry meant is not in the cache afterwards."""
    from .folder import cache

    try:
        found: Any = _import(module, file)
        for part in name.split("."):
            found = getattr(found, part)
        found.compile(pickle.loads(signature))
    except Exception:  # whoever asked for it compiles it in place and sees what is wrong
        return "failed"
    return "done" if (cache.path / entry).is_file() else "lost"


def _import(name: str, file: str) -> Any:
    """A module by its name, or, for those that are written into the cache's folder, by its file, which is run if its
    hash is that in its name. Raises `ImportError`."""
    if name in sys.modules:
        return sys.modules[name]
    from .folder import cache, text_hash

    if Path(file).parent != cache.path:
        return importlib.import_module(name)
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    text = Path(file).read_bytes()
    if not name.endswith(text_hash(text)):
        raise ImportError(f"{file}: its content is not what was written")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    exec(compile(text, file, "exec"), module.__dict__)
    return module


def _ahead(data: bytes, parts: list[str]) -> None:
    """Compile the kernels of a scene's parts."""
    from ..compile_ahead import compile_parts

    try:
        compile_parts(pickle.loads(data), parts)
    except Exception:  # it costs time, nothing else
        return
