"""report.json: what a run did, on which machine, how long each stage took, and how far off it is.

A key that the run has no value for is absent or null; nothing is ever made up. Where several runs draw frames of one
scene into a folder, one after the other or at once, each takes over what the report there says of the earlier frames.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from .. import __version__
from ..errors import StrandError
from . import png
from .files import read_json, write_json
from .frames import Written, frame_file

SCHEMA_VERSION = 1
FILE = "report.json"
PATIENCE = 60.0
"""Seconds to wait for another run that is writing the report: it takes far less than one, or hangs."""


def peak_rss_bytes() -> int:
    """The most memory that this process has had so far; 0 where the system does not tell.

    Linux's ``getrusage`` counts what the process that started this one had then, too; its ``status`` does not.
    """
    try:
        with open("/proc/self/status", encoding="ascii", errors="replace") as status:
            for line in status:
                if line.startswith("VmHWM:"):
                    return int(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    try:
        import resource
    except ImportError:  # no POSIX
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


class RunReport:
    """Collects one run and writes it. ``status`` is complete, interrupted or failed."""

    def __init__(self, preset: str, sha256: str | None, plan: Any, scene: str = "") -> None:
        """``preset`` is the name as it was typed; ``plan`` a `strandcli.plan.Plan`, or None; ``scene`` is the
        `strandcli.run.fingerprint` that frames have in their files."""
        self.preset = {"name": preset, "sha256": sha256 or None}
        self.plan = plan_stages(plan)
        self.plan_warnings: list[str] = list(getattr(plan, "warnings", ()))
        self.scene = scene
        self.frames: dict[int, dict[str, Any]] = {}
        self.failure: dict[str, Any] | None = None
        self.warnings: list[str] = []
        """What a person should know of a run that goes on."""
        self.picture_error: Mapping[str, Any] | None = None
        """What is known of the pictures' error, where one was asked for: `study.advice`."""
        self._start = time.perf_counter()

    def add(self, frame: int, report: Mapping[str, Any]) -> None:
        """Record what the pipeline says of a frame."""
        self.frames[frame] = finite({"frame": frame, **report})

    def fail(self, trouble: Any) -> None:
        """Record what a run stopped for: a `strandcli.simulate.health.Trouble`."""
        self.failure = {
            "frame": trouble.frame, "strand": trouble.strand, "cause": trouble.cause, "message": trouble.message
        }  # fmt: skip

    def as_dict(
        self, status: str, written: Mapping[int, Written], machine: Mapping[str, Any] | None,
        compile_seconds: float | None, previous: Mapping[str, Any] | None = None,
        foreign: Mapping[int, dict[str, Any]] | None = None,
    ) -> dict[str, Any]:  # fmt: skip
        """The whole report, ready for JSON. ``previous`` is the report that lies there, whose entries are taken over
        for frames that this run kept and that are still the same file; ``foreign`` are entries of frames that it has
        nothing to do with, from `foreign_entries`."""
        seconds = time.perf_counter() - self._start
        old = {entry.get("frame"): entry for entry in (previous or {}).get("frames", []) if isinstance(entry, dict)}
        entries = dict(foreign or {})
        fresh = 0
        for frame, done in written.items():
            if frame in self.frames:
                fresh += 1
                entries[frame] = _entry(self.frames[frame], done)
            elif old.get(frame, {}).get("pixels_sha256") == done.pixels_sha256:
                entries[frame] = {**old[frame], "kept": True}
            else:
                entries[frame] = {"frame": frame, "file": done.file, "pixels_sha256": done.pixels_sha256, "kept": True}
        return {
            "schema_version": SCHEMA_VERSION, "strandcli": __version__, "status": status,
            **({"failure": self.failure} if self.failure is not None else {}),
            **({"warnings": self.warnings} if self.warnings else {}),
            **({"picture_error": self.picture_error} if self.picture_error is not None else {}),
            "preset": self.preset, "scene": self.scene or None,
            "machine": dict(machine) if machine is not None else None, "plan": self.plan,
            "compile_seconds": compile_seconds,
            "frames": [entries[frame] for frame in sorted(entries)],
            "totals": {
                "seconds": seconds,
                "frames_per_second": fresh / seconds if fresh and seconds > 0 else None,
                "peak_rss_bytes": peak_rss_bytes() or None,
            },
        }  # fmt: skip


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
    return {"frame": report["frame"], "file": done.file, "pixels_sha256": done.pixels_sha256, "seconds": stages, **rest}


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
    """The report that an earlier run left in ``directory``; None if there is none that can be read, or one of another
    version, or of other files than frames' own."""
    try:
        data = read_json(directory / FILE)
        own = all(one["file"] == frame_file(one["frame"]) for one in data["frames"])
        return dict(data) if own and data["schema_version"] == SCHEMA_VERSION else None
    except (StrandError, TypeError, KeyError):
        return None


def foreign_entries(
    directory: Path, scene: str, previous: Mapping[str, Any] | None, own: Collection[int] = ()
) -> dict[int, dict[str, Any]]:
    """What a ``previous`` report of the scene with this `fingerprint` says of frames whose files are in ``directory``
    and are of that scene, but not of the run's ``own``: by number, marked as kept."""
    if previous is None or not scene or previous.get("scene") != scene:
        return {}
    found: dict[int, dict[str, Any]] = {}
    for entry in previous.get("frames", []):
        number = entry.get("frame") if isinstance(entry, dict) else None
        if not isinstance(number, int) or number in own:
            continue
        if png.keyword(directory / frame_file(number), png.SCENE) == scene:
            found[number] = {**entry, "kept": True}
    return found


def of_another_film(
    directory: Path, scene: str, previous: Mapping[str, Any] | None, frames: Sequence[int]
) -> list[str]:
    """Files that a ``previous`` report lists, besides those of ``frames``, and that are of another scene than the one
    with this `fingerprint`."""
    if previous is None or not scene or previous.get("scene") == scene:
        return []
    numbers = [entry.get("frame") for entry in previous.get("frames", []) if isinstance(entry, dict)]
    files = [frame_file(number) for number in numbers if isinstance(number, int) and number not in frames]
    return [file for file in files if png.keyword(directory / file, png.SCENE) not in (None, scene)]


def write_report(directory: Path, data: Mapping[str, Any]) -> None:
    """Write report.json, whole or not at all."""
    write_json(directory / FILE, data)
