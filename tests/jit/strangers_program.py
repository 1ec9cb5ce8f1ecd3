"""Somebody else's Numba code, as a program: prints what it computes, after a scene has been rendered or without.

With the argument ``plain`` strandcli is never imported; with ``rendered`` a scene is rendered first, and what that has
changed in Numba and in the process is printed to stderr; with ``simulated`` it is simulated alone, and less is
computed.
"""

from __future__ import annotations

import gc
import importlib
import os
import signal
import sys
import tempfile
import threading
from pathlib import Path

import numba
import numpy as np
from numba import njit, prange
from numba.core import event

WATCHED = {
    "numba.core.codegen": ["CPUCodeLibrary", "JITCPUCodegen", "CodeLibrary"],
    "numba.core.dispatcher": ["_FunctionCompiler", "Dispatcher", "_DispatcherBase"],
    "numba.core.registry": ["CPUDispatcher"],
    "numba.core.targetconfig": ["TargetConfig", "ConfigStack"],
    "numba.core.types.functions": ["Function"],
    "numba.core.ir": ["Inst", "FunctionIR"],
    "numba.core.ir_utils": [],
    "numba.core.compiler_machinery": ["PassManager"],
    "numba.core.compiler": ["CompilerBase", "CompileResult"],
    "numba.core.postproc": ["PostProcessor"],
    "numba.core.caching": ["_Cache", "FunctionCache", "IndexDataCacheFile"],
    "numba.core.event": [],
    "numba": [],
}


def state() -> dict[str, object]:
    """What a library may not change: settings, listeners, garbage collection, and Numba's functions by identity."""
    from llvmlite.binding import ffi

    numba.get_num_threads()
    listeners = {name: list(found) for name, found in event._registered.items() if found}
    kept: dict[str, object] = {
        "config": {name: value for name, value in vars(numba.config).items() if name.isupper()},
        "environ": dict(os.environ),
        "gc": (gc.get_threshold(), gc.isenabled(), len(gc.callbacks)),
        "listeners": listeners,
        "lock callbacks": list(ffi.lib._lock._cblist),
        "threads": numba.get_num_threads(),
        "signals": [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)],
        "floating point": np.geterr(),
        "path": list(sys.path),
        "other threads": threading.active_count(),
    }
    for module, classes in WATCHED.items():
        found = importlib.import_module(module)
        for owner in [found, *(getattr(found, name) for name in classes if hasattr(found, name))]:
            for name, value in vars(owner).items():
                if callable(value) or isinstance(value, staticmethod | classmethod | property):
                    kept[f"{getattr(owner, '__qualname__', module)}.{name}"] = id(value)
    return kept


def render(draw: bool) -> None:
    """Render two frames on one thread, where all are set, and one on another thread."""
    numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
    before = state()
    import strandcli
    from strandcli.run.pipeline import render as run

    changes = ["image.size=48x32", "emitter.strands=20", "time.preroll=0"]
    scene = strandcli.load("minimal", overrides=changes)
    for frame in strandcli.render(scene, [1, 2], threads=1) if draw else run(scene, [1, 2], threads=1, draw=False):
        assert (frame.image is not None) == draw
        assert numba.get_num_threads() == numba.config.NUMBA_NUM_THREADS
    elsewhere: list[bool] = []

    def work() -> None:
        numba.set_num_threads(1)
        list(run(scene, [1], draw=draw))
        elsewhere.append(numba.get_num_threads() == 1)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert elsewhere == [True]
    after = state()
    for name in {**before, **after}:
        if before.get(name) != after.get(name):
            print(f"changed: {name}: {before.get(name)} -> {after.get(name)}", file=sys.stderr)


def loops_closures_recursion() -> None:
    @njit(parallel=True)
    def total(x):
        s = 0.0
        for i in prange(x.shape[0]):
            s += x[i]
        return s

    def scaled(by):
        @njit
        def inner(x):
            return x * by

        return inner

    @njit
    def fibonacci(n):
        if n < 2:
            return n
        return fibonacci(n - 1) + fibonacci(n - 2)

    print(total(np.arange(1000.0)), scaled(3)(4), scaled(2.5)(4), fibonacci(12))


CACHED = """
import numba
from numba import njit
@njit(cache=True)
def one(x): return x + 1
@njit(cache=True, parallel=True)
def all_of(x):
    s = 0.0
    for i in numba.prange(len(x)): s += x[i]
    return s
"""


def cached() -> None:
    folder = Path(tempfile.mkdtemp())
    (folder / "cached_by_a_stranger.py").write_text(CACHED, encoding="utf-8")
    sys.path.insert(0, str(folder))
    module = importlib.import_module("cached_by_a_stranger")
    print(module.one(1), module.all_of(np.ones(100)))
    print(sorted(path.suffix for path in (folder / "__pycache__").iterdir()))


if __name__ == "__main__":
    if sys.argv[1] != "plain":
        render(draw=sys.argv[1] == "rendered")
    loops_closures_recursion()
    if sys.argv[1] != "simulated":
        cached()
