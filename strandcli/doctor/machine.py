"""Processor, cores, memory, disk."""

from __future__ import annotations

import os
import platform
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from ..common import limits
from ..common.counted import counted
from ..errors import UsageError
from . import BROKEN, NOTE, OK, Finding

WIDE = ("avx512f", "avx2", "avx", "sse4.2", "sve", "neon")
"""Vector instructions, widest first."""
LEAST_MEMORY = 1_000_000_000
"""Bytes: a frame of a shipped preset takes 600 MB and less."""
LEAST_DISK = 500_000_000


def processor() -> Iterator[Finding]:
    """The processor and the vector instructions that LLVM uses of it."""
    try:
        import llvmlite.binding as llvm
    except Exception:  # told by another check
        return
    from ..compiling.runtime import cpu_name

    features = llvm.get_host_cpu_features()
    known = [name for name in WIDE if features.get(name)]
    more = ["fma"] if features.get("fma") else []
    text = f"{cpu_name()}, {llvm.get_host_cpu_name()}: {', '.join([*known, *more]) or 'no vector instructions'}"
    if platform.machine() in ("x86_64", "AMD64") and not features.get("avx2"):
        yield Finding("processor", NOTE, text, "without AVX2 kernels run at half the speed; the pictures are good")
    else:
        yield Finding("processor", OK, text)


def threads() -> Iterator[Finding]:
    """Cores that there are, that this process may use, and the threads that it takes by default."""
    there = os.cpu_count() or 1
    usable, quota = limits.cores(), limits.quota()
    from ..compiling.runtime import checked_threads

    try:
        count = checked_threads(None)
    except UsageError as error:
        yield Finding("threads", BROKEN, str(error), "unset the variable")
        return
    except ImportError:  # told by another check
        return
    text = f"{count} by default; {counted(there, 'core')}, of which this process may use {usable}"
    if quota is not None:
        text += f", and {quota:g} cores' time by its control group"
    if quota is not None and count > max(1.0, quota) + 0.5:
        fewer = max(1, round(quota))
        yield Finding(
            "threads", NOTE, text, f"threads wait for each other: take --threads {fewer} or NUMBA_NUM_THREADS={fewer}"
        )
    elif count < usable and "NUMBA_NUM_THREADS" in os.environ:
        yield Finding("threads", NOTE, f"{text}; NUMBA_NUM_THREADS={count}", "unset NUMBA_NUM_THREADS to use all cores")
    else:
        yield Finding("threads", OK, text)


def memory() -> Iterator[Finding]:
    """Memory that is free, for the system and for this process's control group."""
    from ..output.files import megabytes

    free, most = limits.available_memory(), limits.memory()
    if free is None:
        yield Finding("memory", NOTE, "not known on this system", "'strandcli plan PRESET' reports what a run takes")
        return
    text = f"{megabytes(free)} free" + ("" if most is None else f", limit of its control group {megabytes(most)}")
    if free < LEAST_MEMORY:
        yield Finding("memory", NOTE, text, "end other programs, or draw with smaller --size and fewer --strands")
    else:
        yield Finding("memory", OK, text)


def disk() -> Iterator[Finding]:
    """Room and permission where frames go by default, and for temporary files."""
    from ..output.files import megabytes

    for what, place in (("disk", Path.cwd()), ("temporary", Path(tempfile.gettempdir()))):
        free = shutil.disk_usage(place).free
        text = f"{place}: {megabytes(free)} free"
        if not os.access(place, os.W_OK):
            yield Finding(what, NOTE, f"{text}, and no permission to write", "choose a folder for frames with -o")
        elif free < LEAST_DISK:
            yield Finding(what, NOTE, text, "free some space, or choose another folder with -o")
        else:
            yield Finding(what, OK, text)
