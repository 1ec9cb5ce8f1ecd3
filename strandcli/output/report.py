"""report.json: what a run did, on which machine, how long each stage took, and how far off it is.

A key that the run has no value for is absent or null; nothing is ever made up.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import resource
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .. import __version__
from .files import write_json
from .frames import Written

SCHEMA_VERSION = 1
FILE = "report.json"


def peak_rss_bytes() -> int:
    """The most memory that this process has held so far."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def fingerprint(scene: Any, *more: str) -> str:
    """Hash of everything in a scene that changes its pixels, and of this version of strandcli.

    Left out: where the scene was read from, its title, and how many frames the film has, so that a longer film can
    resume a shorter one.
    """
    data = json.dumps([__version__, _values(scene), *more], sort_keys=True, default=repr)
    return hashlib.sha256(data.encode()).hexdigest()[:32]


_IGNORED = {"Scene": {"source", "sha256", "title"}, "RuleUse": {"path"}, "Time": {"frames"}, "Image": {"aovs"}}


def _values(thing: Any) -> Any:
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        kind = type(thing).__name__
        names = [f.name for f in dataclasses.fields(thing) if f.name not in _IGNORED.get(kind, ())]
        return {"": kind, **{name: _values(getattr(thing, name)) for name in names}}
    if isinstance(thing, tuple | list):
        return [_values(one) for one in thing]
    return thing


class RunReport:
    """Collects one run and writes it. ``status`` is complete, interrupted or failed."""

    def __init__(self, preset: str, sha256: str | None, plan: Any) -> None:
        """``preset`` is the name as it was typed; ``plan`` a `strandcli.plan.Plan`, or None."""
        self.preset = {"name": preset, "sha256": sha256 or None}
        self.plan = plan_stages(plan)
        self.frames: dict[int, dict[str, Any]] = {}
        self.failure: dict[str, Any] | None = None
        self.warnings: list[str] = []
        self._start = time.perf_counter()

    def add(self, frame: int, report: Mapping[str, Any]) -> None:
        """Record what the pipeline says of a frame."""
        self.frames[frame] = finite({"frame": frame, **report})

    def fail(self, trouble: Any) -> None:
        """Record what a run stopped for: a `strandcli.simulate.health.Trouble`."""
        self.failure = {
            "frame": trouble.frame, "strand": trouble.strand, "cause": trouble.cause, "message": trouble.message
        }  # fmt: skip

    def warn(self, message: str) -> None:
        """Record what a person should know of a run that goes on."""
        self.warnings.append(message)

    def as_dict(
        self,
        status: str,
        written: Mapping[int, Written],
        machine: Mapping[str, Any] | None,
        compile_seconds: float | None,
        previous: Mapping[str, Any] | None = None,
    ) -> dict[str, Any]:
        """The whole report, ready for JSON. ``previous`` is the report of the run that is resumed, whose entries are
        taken over for frames that are still the same file."""
        seconds = time.perf_counter() - self._start
        old = {entry.get("frame"): entry for entry in (previous or {}).get("frames", []) if isinstance(entry, dict)}
        entries = []
        fresh = 0
        for frame in sorted(set(self.frames) | set(written)):
            done = written.get(frame)
            if done is None:
                continue
            if frame in self.frames:
                fresh += 1
                entries.append(_entry(self.frames[frame], done))
            elif old.get(frame, {}).get("pixels_sha256") == done.pixels_sha256:
                entries.append({**old[frame], "kept": True})
            else:
                entries.append({"frame": frame, "file": done.file, "pixels_sha256": done.pixels_sha256, "kept": True})
        return {
            "schema_version": SCHEMA_VERSION,
            "strandcli": __version__,
            "status": status,
            **({"failure": self.failure} if self.failure is not None else {}),
            **({"warnings": self.warnings} if self.warnings else {}),
            "preset": self.preset,
            "machine": dict(machine) if machine is not None else None,
            "plan": self.plan,
            "compile_seconds": compile_seconds,
            "frames": entries,
            "totals": {
                "seconds": seconds,
                "frames_per_second": fresh / seconds if fresh and seconds > 0 else None,
                "peak_rss_bytes": peak_rss_bytes(),
            },
        }


def plan_stages(plan: Any) -> dict[str, Any] | None:
    """The `plan` mapping: what is used and what is left out, each with its reason."""
    if plan is None:
        return None
    lists = {"used": plan.used, "left_out": plan.left_out}
    return {key: [{"stage": one.stage, "why": one.why} for one in stages] for key, stages in lists.items()}


def _entry(report: Mapping[str, Any], done: Written) -> dict[str, Any]:
    """One frame: the pipeline's words, with the file's. ``total`` is the work of all stages, of which writing runs
    beside the next frame."""
    stages = {name: value for name, value in report.get("seconds", {}).items() if name != "total"}
    if done.seconds is not None:
        stages["write"] = done.seconds
    known = [value for value in stages.values() if value is not None]
    stages["total"] = sum(known) if known else None
    rest = {key: value for key, value in report.items() if key not in ("frame", "seconds")}
    return {
        "frame": report["frame"],
        "file": done.file,
        "pixels_sha256": done.pixels_sha256,
        "seconds": stages,
        **rest,
    }


def finite(value: Any) -> Any:
    """The same data for JSON: NumPy numbers become plain ones, and NaN or infinity, which JSON lacks, null."""
    if isinstance(value, Mapping):
        return {str(key): finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [finite(one) for one in value]
    if hasattr(value, "item") and not isinstance(value, str | bytes):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def read_report(directory: Path) -> dict[str, Any] | None:
    """The report that an earlier run left in ``directory``, or None if there is none that can be read."""
    try:
        data = json.loads((directory / FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    return data if isinstance(data, dict) and isinstance(data.get("frames", []), list) else None


def write_report(directory: Path, data: Mapping[str, Any]) -> Path:
    """Write report.json, whole or not at all."""
    path = directory / FILE
    write_json(path, data)
    return path
