"""What is known of this machine's speed, in a file of the cache folder. A damaged file, or one of another machine or
version, is as none: the speed is measured anew."""

from __future__ import annotations

import json
import math
import os
import platform
import time
from dataclasses import dataclass, field
from importlib import metadata
from typing import Any

from .. import __version__
from ..compiling.folder import cache
from ..compiling.runtime import cpu_name

FILE = "speed.json"
SCHEMA_VERSION = 1
LEAST, MOST = 1e-3, 1e4
"""Factors that are believed."""
REMEMBERED = 5
"""Runs over which what is learned is averaged, the newer ones more."""


@dataclass
class Kind:
    """What runs of one kind of scenes have shown (see `plan.cost.kind_of`)."""

    factor: float
    runs: int


@dataclass
class Profile:
    """Times that this machine takes, over those of `strandcli.plan.cost`."""

    factor: float
    """Measured by `measure`."""
    measured: str
    """The day, as 2026-01-31."""
    kinds: dict[str, Kind] = field(default_factory=dict)

    def of(self, kind: str) -> tuple[float, int]:
        """Return the factor of a kind of scenes and the number of runs that it is from; 0: the machine's own."""
        known = self.kinds.get(kind)
        return (self.factor, 0) if known is None else (known.factor, known.runs)

    def learn(self, kind: str, factor: float) -> None:
        """Take in what a run has shown."""
        if not LEAST <= factor <= MOST:
            return
        known = self.kinds.get(kind)
        if known is None:
            self.kinds[kind] = Kind(factor, 1)
            return
        share = 1 / min(known.runs + 1, REMEMBERED)
        mean = math.exp((1 - share) * math.log(known.factor) + share * math.log(factor))
        self.kinds[kind] = Kind(mean, known.runs + 1)


def today() -> str:
    """Return the date, as profiles have it."""
    return time.strftime("%Y-%m-%d")


def machine() -> dict[str, Any]:
    """Return what a profile holds for."""
    return {
        "cpu": cpu_name(), "cores": os.cpu_count(), "strandcli": __version__, "numba": metadata.version("numba"),
        "python": platform.python_version(),
    }  # fmt: skip


def read() -> Profile | None:
    """Return this machine's profile; None where there is none that can be believed."""
    try:
        data = json.loads(cache.find(FILE).read_text(encoding="utf-8"))
        if data["schema_version"] != SCHEMA_VERSION or data["machine"] != machine():
            return None
        kinds = {str(name): Kind(_factor(one["factor"]), _whole(one["runs"])) for name, one in data["kinds"].items()}
        return Profile(_factor(data["factor"]), str(data["measured"])[:10], kinds)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def write(profile: Profile) -> bool:
    """Keep a profile, whole or not at all; returns whether it is kept."""
    kinds = {name: {"factor": one.factor, "runs": one.runs} for name, one in sorted(profile.kinds.items())}
    data = {"schema_version": SCHEMA_VERSION, "machine": machine(), "factor": profile.factor,
            "measured": profile.measured, "kinds": kinds}  # fmt: skip
    return cache.write(cache.path / FILE, json.dumps(data, indent=1).encode())


def _factor(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not LEAST <= value <= MOST:
        raise ValueError("not a factor")
    return float(value)


def _whole(value: Any) -> int:
    if type(value) is not int or value < 1:
        raise ValueError("not a number of runs")
    return value
