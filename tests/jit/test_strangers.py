"""Other people's Numba code in the same process: Numba, the environment and the process are left as they were found."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

PROGRAM = """
import gc, importlib, os, signal, sys, threading
import numba, numpy as np
from llvmlite.binding import ffi
from numba.core import event

WATCHED = {
    "numba.core.codegen": ["CPUCodeLibrary", "JITCPUCodegen", "CodeLibrary"],
    "numba.core.dispatcher": ["_FunctionCompiler", "Dispatcher", "_DispatcherBase"],
    "numba.core.registry": ["CPUDispatcher"], "numba.core.targetconfig": ["TargetConfig", "ConfigStack"],
    "numba.core.types.functions": ["Function"], "numba.core.ir": ["Inst", "FunctionIR"], "numba.core.ir_utils": [],
    "numba.core.compiler_machinery": ["PassManager"], "numba.core.compiler": ["CompilerBase", "CompileResult"],
    "numba.core.postproc": ["PostProcessor"], "numba.core.event": [], "numba": [],
    "numba.core.caching": ["_Cache", "FunctionCache", "IndexDataCacheFile"],
}

def state():
    numba.get_num_threads()
    found = {
        "config": {name: value for name, value in vars(numba.config).items() if name.isupper()},
        "environ": dict(os.environ), "gc": (gc.get_threshold(), gc.isenabled(), len(gc.callbacks)),
        "listeners": {name: list(some) for name, some in event._registered.items() if some},
        "lock callbacks": list(ffi.lib._lock._cblist), "threads": numba.get_num_threads(),
        "signals": [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)],
        "floating point": np.geterr(), "path": list(sys.path), "other threads": threading.active_count(),
    }
    for module, classes in WATCHED.items():
        whole = importlib.import_module(module)
        for owner in [whole, *(getattr(whole, name) for name in classes)]:
            for name, value in vars(owner).items():
                if callable(value) or isinstance(value, staticmethod | classmethod | property):
                    found[f"{owner.__name__}.{name}"] = id(value)
    return found

numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
before = state()
import strandcli
from strandcli.run.pipeline import render

scene = strandcli.load("minimal", overrides=["image.size=48x32", "emitter.strands=20", "time.preroll=0"])
draw = sys.argv[1] == "drawn"
for frame in render(scene, [1, 2], threads=1, draw=draw):
    assert numba.get_num_threads() == numba.config.NUMBA_NUM_THREADS
elsewhere = []

def work():
    numba.set_num_threads(1)
    list(render(scene, [1], draw=draw))
    elsewhere.append(numba.get_num_threads())

thread = threading.Thread(target=work)
thread.start()
thread.join()
assert elsewhere == [1]
after = state()
for name in {**before, **after}:
    if before.get(name) != after.get(name):
        print(f"changed: {name}: {before.get(name)} -> {after.get(name)}")
"""


def changes(what: str, **environment: str) -> str:
    """What has changed when a scene was rendered, on one thread where all are set and on another thread."""
    place = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2]), "PYTHONWARNINGS": "ignore", **environment}
    done = subprocess.run([sys.executable, "-c", PROGRAM, what], env=place, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_nothing_of_numba_has_changed_after_a_render() -> None:
    assert changes("drawn") == ""


def test_nothing_changes_where_kernels_are_compiled_in_place(tmp_path: Path) -> None:
    """With an empty cache and without workers."""
    assert changes("moved", STRANDCLI_COMPILERS="0", STRANDCLI_CACHE_DIR=str(tmp_path / "cache")) == ""
