"""The machine that kernels run on: threads, Numba's cache folder, and the time that compiling takes.

Modules that hold kernels take their decorators from `strandcli.jit`, which calls `start_once`; everything else stays
away from numba, whose import alone takes a fifth of a second.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from . import __version__
from .errors import UsageError

SPINS = "30000"
"""How often an idle thread looks for work before it sleeps. GNU's OpenMP looks 300,000 times, a millisecond in which
another process could have run: beside a busy one, small frames took 3 to 40 times as long. Less than this and
every step of a small simulation waits for a thread to wake up."""

MOST_THREADS = 4096
"""That NUMBA_NUM_THREADS may ask for; of a hundred thousand Numba crashes."""

_state: dict[str, Any] = {
    "folder": None,
    "trouble": None,
    "compile_seconds": 0.0,
    "depth": 0,
    "began": 0.0,
    "notify": None,
}


def start(threads: int | None = None, notify: Callable[[str], None] | None = None) -> None:
    """Choose the cache folder and the number of threads; safe to call again with another number.

    ``notify`` is handed a line of text each time that compiling begins. Raises `UsageError` for a number of threads
    that this machine does not have, and for settings of Numba's with which nothing can be drawn.
    """
    _prepare(notify)
    import numba

    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        raise UsageError("NUMBA_DISABLE_JIT is set, and strandcli does nothing without Numba's compiler: unset it")
    most = int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]
    if threads is None:
        threads = most
    if not 1 <= threads <= most:
        raise UsageError(f"--threads {threads}: this machine offers 1 to {most}")
    numba.set_num_threads(threads)


def _prepare(notify: Callable[[str], None] | None) -> None:
    """What `start` does once, but for the message."""
    _state["notify"] = notify
    if _state["folder"] is None:
        _check_threads_of_environment()
        _state["folder"] = _writable_folder()
        os.environ["NUMBA_CACHE_DIR"] = str(_state["folder"])
        if "OMP_WAIT_POLICY" not in os.environ:  # read once, when OpenMP's library is loaded
            os.environ.setdefault("GOMP_SPINCOUNT", SPINS)
        if "numba" in sys.modules:
            sys.modules["numba"].config.CACHE_DIR = str(_state["folder"])
        _watch()


def _check_threads_of_environment() -> None:
    """Raise `UsageError` for numbers of threads that Numba would take from its variable, and fail by."""
    asked = os.environ.get("NUMBA_NUM_THREADS")
    if asked is None:
        return
    try:
        fine = 1 <= int(asked) <= MOST_THREADS
    except ValueError:
        fine = False
    if not fine:
        raise UsageError(
            f"NUMBA_NUM_THREADS={asked!r}: must be a whole number from 1 to {MOST_THREADS}; where it is not set, each "
            "core has a thread"
        )


def start_once() -> None:
    """The same for callers of the Python side who never said anything; functions may be called without a compiler."""
    if _state["folder"] is None:
        _prepare(None)


def cache_folder() -> Path:
    """The private folder that holds compiled and generated kernels."""
    start_once()
    return Path(_state["folder"])


def shared_folder() -> Path | None:
    """That folder where other processes find it again, None where it is a temporary one of this process."""
    folder = cache_folder()
    return None if _state["trouble"] else folder


def cache_trouble() -> str | None:
    """What keeps compiled kernels from being kept for the next run, and what to do about it; None where they are."""
    start_once()
    trouble: str | None = _state["trouble"]
    return trouble


@contextmanager
def counted_as_compiling(what: str) -> Iterator[None]:
    """Time within counts as compiling."""
    if _state["notify"] is not None:
        _state["notify"](f"compiling {what}")
    began = time.perf_counter()
    try:
        yield
    finally:
        _state["compile_seconds"] += time.perf_counter() - began


def compile_seconds() -> float:
    """Seconds that this process has spent compiling kernels so far (0 when all came from the cache)."""
    return float(_state["compile_seconds"])


def machine() -> dict[str, Any]:
    """What the figures of this run were measured on; the `machine` mapping of report.json."""
    import llvmlite
    import numba

    try:
        layer: str | None = numba.threading_layer()
    except ValueError:  # no parallel kernel has run yet
        layer = None
    return {
        "cpu": _cpu_name(),
        "cores": os.cpu_count(),
        "threads": int(numba.get_num_threads()),
        "threading_layer": layer,
        "python": platform.python_version(),
        "numba": numba.__version__,
        "llvm": ".".join(str(part) for part in llvmlite.binding.llvm_version_info),
        "llvmlite": llvmlite.__version__,
    }


def entered_by_several() -> bool:
    """Whether threads may run kernels side by side, once one has run: Numba's own threading layer aborts the process,
    which is all that it has where there is neither OpenMP nor TBB."""
    import numba

    return bool(numba.threading_layer() != "workqueue")


def source_hash() -> str:
    """A short hash over every source file that kernels are made of: kernels cached from other sources are never reused,
    because Numba itself does not notice that a function in another file has changed."""
    digest = hashlib.sha256()
    root = Path(__file__).parent
    patterns = "**/kernels/*.py", "simulate/rules/*.py", "simd/*.py", "jit.py", "compiler.py", "constants.py"
    for path in sorted(path for pattern in patterns for path in root.glob(pattern)):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:12]


def _writable_folder() -> Path:
    """A private folder for this user and these sources; a temporary one where the user's cache cannot be written."""
    import platformdirs

    chosen = os.environ.get("STRANDCLI_CACHE_DIR")
    base = Path(chosen) if chosen else Path(platformdirs.user_cache_dir("strandcli", appauthor=False))
    folder = base / f"kernels-{__version__}"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        os.utime(folder)
        _forget_old(base, keep=folder)
    except OSError as error:
        _state["trouble"] = (
            f"{folder}: compiled kernels cannot be kept there ({error.strerror or error}): every run will compile "
            "anew; point STRANDCLI_CACHE_DIR at a folder that can be written"
        )
        folder = Path(tempfile.mkdtemp(prefix="strandcli-"))
        import atexit

        atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _forget_old(base: Path, keep: Path, days: float = 14.0) -> None:
    """Remove kernels of other versions that nobody has used for a while: only folders that were named here, because
    ``base`` may be any folder of the user's."""
    for other in base.iterdir():
        ours = re.fullmatch(r"\d+\.\d+\.\w+-[0-9a-f]{12}", other.name) is not None
        if ours and other != keep and other.is_dir() and other.stat().st_mtime < time.time() - 86_400 * days:
            shutil.rmtree(other, ignore_errors=True)


def _watch() -> None:
    """Time compilation through Numba's events, and survive a damaged cache (Numba #10434: a truncated file raises)."""
    from numba.core import event

    from .compiler import kernel, spare

    spare()

    class Clock(event.Listener):
        def on_start(self, happening: Any) -> None:
            kernel.begin()
            if _state["depth"] == 0:
                _state["began"] = time.perf_counter()
                if _state["notify"] is not None:
                    _state["notify"](f"compiling {happening.data['dispatcher'].py_func.__name__}")
            _state["depth"] += 1

        def on_end(self, happening: Any) -> None:
            kernel.end()
            _state["depth"] -= 1
            if _state["depth"] == 0:
                _state["compile_seconds"] += time.perf_counter() - _state["began"]

    event.register("numba:compile", Clock())


def damaged(path: Path, error: Exception) -> None:
    """A cache entry is not what was written: it is removed, and the kernel compiled anew."""
    if _state["notify"] is not None:
        _state["notify"](f"{path}: cached kernel cannot be loaded ({error}): compiling anew")
    with contextlib.suppress(OSError):
        path.unlink()


def unwritable(error: OSError) -> None:
    """A compiled kernel could not be kept."""
    if _state["notify"] is not None:
        _state["notify"](f"a compiled kernel cannot be kept: {error.strerror or error}")


def _cpu_name() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            for line in lines:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
