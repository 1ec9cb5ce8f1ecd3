"""The machine that kernels run on: its threads, the cache folder, and the time that compiling takes.

Numba is imported when it is needed: its import alone takes a fifth of a second.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ..errors import RefusedError, UsageError, said
from .clock import clock
from .folder import cache

SPINS = "30000"
"""How often an idle thread looks for work before it sleeps. GNU's OpenMP looks 300,000 times, a millisecond in which
another process could have run: beside a busy one, small frames took 3 to 40 times as long. Less than this and
every step of a small simulation waits for a thread to wake up."""

MOST_THREADS = 4096
"""That NUMBA_NUM_THREADS may ask for; of a hundred thousand Numba crashes."""

ADDRESSES = 800_000_000
"""Bytes of addresses that Python takes with the libraries, NumPy's and LLVM's among them, and a small picture."""

M_MMAP_THRESHOLD = -3
"""Of mallopt(3): bytes from which on arrays have pages of their own."""
LARGE = 8 << 20
"""Bytes, above the temporary arrays of kernels and readers, which are made again and again."""

NO_COMPILER = "NUMBA_DISABLE_JIT is set, and strandcli draws and reads nothing without Numba's compiler: unset it"


def start(threads: int | None = None, notify: Callable[[str], None] | None = None) -> None:
    """Set the number of threads, for the thread that calls; all by default.

    ``notify`` is handed a line of text each time that compiling begins. Raises `UsageError` for a number of threads
    that this machine does not have, and for settings of Numba's with which nothing can be drawn.
    """
    count = checked_threads(threads)
    tell(notify)
    import numba

    numba.set_num_threads(count)


def tell(notify: Callable[[str], None] | None, warn: Callable[[str], None] | None = None) -> None:
    """``notify`` is handed what is compiled from now on, ``warn`` that kernels cannot be stored, if that happens."""
    clock.notify = notify
    cache.warn = warn


def checked_threads(threads: int | None) -> int:
    """The number of threads to use; all for None. Raises `UsageError` as `start` does."""
    require_threads()
    import numba

    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        raise UsageError(NO_COMPILER)
    most = int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]
    _check_threading_layer()
    if threads is None:
        threads = most
    if not 1 <= threads <= most:
        raise UsageError(f"--threads {threads}: this machine offers 1 to {most}")
    return threads


def lacks_compiler(error: BaseException) -> bool:
    """Whether an error is Numba's message that a kernel cannot run without its compiler, which is switched off."""
    if not isinstance(error, NotImplementedError) or "numba" not in sys.modules:
        return False
    import numba

    return bool(numba.config.DISABLE_JIT)  # type: ignore[attr-defined]


@contextmanager
def thread_count(count: int) -> Iterator[None]:
    """A block in which kernels that this thread calls use so many threads; afterwards as many as before."""
    import numba

    before = numba.get_num_threads()
    numba.set_num_threads(count)
    try:
        yield
    finally:
        numba.set_num_threads(before)


def still_idle_threads() -> None:
    """Have threads of libraries that wait beside ours keep still, in a process of our own; they read it when they are
    loaded. OpenMP's sleep sooner, and OpenBLAS has none of its own: its products are small here, and have the same bits
    on any number of cores then."""
    if "OMP_WAIT_POLICY" not in os.environ:
        os.environ.setdefault("GOMP_SPINCOUNT", SPINS)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def give_back_large() -> None:
    """Have large arrays that are freed go back to the system at once, in a process of our own. GNU's C library puts
    them by default, once some have been freed, where they stay: a twentieth of what a dense groom takes.
    """
    if sys.platform != "linux" or "MALLOC_MMAP_THRESHOLD_" in os.environ:
        return
    import ctypes

    with suppress(OSError, AttributeError):  # of C libraries that have no such setting
        ctypes.CDLL(None).mallopt(M_MMAP_THRESHOLD, LARGE)


def address_limit() -> int | None:
    """Bytes of addresses that this process may use, such as a shell sets by ``ulimit -v``; None where all are free."""
    try:
        import resource
    except ImportError:  # no POSIX
        return None
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if limit == resource.RLIM_INFINITY else limit


def require_addresses() -> None:
    """Raise `RefusedError` where libraries cannot be loaded: some end the process then, without a word of ours."""
    limit = address_limit()
    if limit is not None and limit < ADDRESSES:
        raise RefusedError(
            f"this process may use {limit / 1e6:,.0f} MB of addresses, and the libraries take {ADDRESSES / 1e6:,.0f}; "
            "raise the limit: 'ulimit -v unlimited'"
        )


def _check_threading_layer() -> None:
    """Raise `UsageError` for a threading layer that Numba is asked for and has not."""
    import numba

    asked = str(numba.config.THREADING_LAYER)  # type: ignore[attr-defined]
    if asked == "default":
        return
    from numba.np.ufunc import parallel

    try:
        parallel._launch_threads()
    except ValueError as error:
        raise UsageError(
            f"NUMBA_THREADING_LAYER={asked}: {said(error)}; unset it, and Numba takes one that is there"
        ) from None


def require_threads() -> None:
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


def cache_folder() -> Path:
    """The private folder that holds compiled and generated kernels."""
    return cache.path


def compile_seconds() -> float:
    """Seconds that this process has waited for kernels to be compiled so far (0 when all came from the cache)."""
    return clock.seconds


def machine() -> dict[str, Any]:
    """What the figures of this run were measured on; the `machine` mapping of report.json."""
    import llvmlite
    import numba

    try:
        layer: str | None = numba.threading_layer()
    except ValueError:  # no parallel kernel has run yet
        layer = None
    return {
        "cpu": cpu_name(), "cores": os.cpu_count(), "threads": int(numba.get_num_threads()), "threading_layer": layer,
        "python": platform.python_version(), "numba": numba.__version__,
        "llvm": ".".join(str(part) for part in llvmlite.binding.llvm_version_info), "llvmlite": llvmlite.__version__,
    }  # fmt: skip


def entered_by_several() -> bool:
    """Whether threads may run kernels side by side, once one has run: Numba's own threading layer aborts the process,
    which is all that it has where there is neither OpenMP nor TBB."""
    import numba

    return bool(numba.threading_layer() != "workqueue")


def cpu_name() -> str:
    """The name of the processor, as the system tells it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            for line in lines:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
