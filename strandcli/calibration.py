"""How fast this machine draws: a few frames of a shipped preset by the processor's time of one thread, measured once
and stored in the cache folder. A damaged file, or one of another machine or version, is as none."""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Callable
from importlib import metadata
from typing import Any, NamedTuple

from . import __version__
from .compiling.folder import cache
from .compiling.runtime import cpu_name

FILE, SCHEMA_VERSION = "speed.json", 1
LEAST, MOST = 1e-3, 1e4
"""Factors that are believed."""
WITHIN = 2.0
"""Times by which planned seconds may be off, on a machine that does nothing else."""
PRESET = "minimal"
SETTINGS: dict[str, Any] = {"image.size": [400, 300], "time.preroll": 0.0, "emitter.strands": 6000}
FRAMES = 8
REFERENCE = 0.039
"""Seconds of the fastest of these frames on the machine that `strandcli.plan.cost` is about."""


class Speed(NamedTuple):
    """Times that this machine takes over those of `strandcli.plan.cost`, and the day when it was measured."""

    factor: float
    measured: str


def measure(notify: Callable[[str], None] | None = None) -> Speed:
    """Measure this machine. Takes two seconds, and a minute where kernels are compiled first. What other programs do
    meanwhile is not counted."""
    from . import load
    from .compiling import runtime
    from .study.bench_preset import time_stages

    runtime.tell(notify)
    with runtime.thread_count(1):
        timed, _ = time_stages(load(PRESET, settings=SETTINGS), FRAMES - 1, time.process_time, notify)
    took = min(sum(value for stage, value in seconds.items() if stage != "write") for seconds, _ in timed)
    return Speed(took / REFERENCE, time.strftime("%Y-%m-%d"))


def machine() -> dict[str, Any]:
    """Return what a measured speed holds for."""
    return {
        "cpu": cpu_name(), "cores": os.cpu_count(), "strandcli": __version__, "numba": metadata.version("numba"),
        "python": platform.python_version(),
    }  # fmt: skip


def read() -> Speed | None:
    """Return this machine's speed; None where none is stored that can be believed."""
    try:
        data = json.loads(cache.find(FILE).read_text(encoding="utf-8"))
        factor = data["factor"]
        if data["schema_version"] != SCHEMA_VERSION or data["machine"] != machine() or type(factor) not in (int, float):
            return None
        return Speed(float(factor), str(data["measured"])[:10]) if LEAST <= factor <= MOST else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def write(speed: Speed) -> bool:
    """Store a speed, whole or not at all; returns whether it is."""
    data = {"schema_version": SCHEMA_VERSION, "machine": machine(), **speed._asdict()}
    return cache.write(cache.path / FILE, json.dumps(data, indent=1).encode())
