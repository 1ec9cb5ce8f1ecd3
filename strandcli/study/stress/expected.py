"""Failures that are known and kept, by name: ``expected_thesis.txt``, which `write` makes and people read.

The file has a reason for each metric (``@metric reason``), then a line for each scene: the metrics that fail, the
scene's name, and the starts from which they do. A case that fails in any other metric, or is not listed, has failed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path

from ...output.files import write_pieces

START = "/start="
DEFAULT = "straight"


@cache
def _read(solver: str) -> tuple[dict[str, str], dict[tuple[str, str], str]]:
    """Reasons by metric, and what is listed: (name, metric) with its reason."""
    try:
        text = files(__package__).joinpath(f"expected_{solver}.txt").read_text(encoding="utf-8")
    except FileNotFoundError:
        return {}, {}
    reasons: dict[str, str] = {}
    listed: dict[tuple[str, str], str] = {}
    for line in text.splitlines():
        if line.startswith("@"):
            metric, _, reason = line[1:].partition(" ")
            reasons[metric] = reason
        elif line and not line.startswith("#"):
            metrics, scene, *starts = line.split(" ")
            for start in starts:
                name = scene if start == DEFAULT else scene + START + start
                for metric in metrics.split(","):
                    listed[f"{solver}/{name}".rstrip("/"), metric] = reasons[metric]
    return reasons, listed


def reason(name: str, metric: str) -> str:
    """Why this failure was expected; "" where it was not."""
    return _read(name.partition("/")[0])[1].get((name, metric), "")


def passed_after_all(solver: str, failed: Iterable[tuple[str, str]], ran: Iterable[str]) -> list[str]:
    """Names of cases that ran, and failed in less than what is listed for them."""
    happened, seen = set(failed), set(ran)
    return sorted({name for name, metric in _read(solver)[1] if name in seen and (name, metric) not in happened})


def text_of(solver: str, reasons: Mapping[str, str], failed: Iterable[tuple[str, str]]) -> str:
    """The file for these failures: (name, metric)."""
    scenes: dict[str, dict[str, list[str]]] = {}
    for name, metric in failed:
        scene, _, start = name.partition(START)
        scenes.setdefault(scene, {}).setdefault(start or DEFAULT, []).append(metric)
    lines = [f"# Failures of the solver {solver} that are known and kept, as `strandcli stress --accept` wrote them."]
    lines += [f"@{metric} {why}" for metric, why in reasons.items()]
    for scene, starts in sorted(scenes.items()):
        alike: dict[str, list[str]] = {}
        for start, metrics in starts.items():
            alike.setdefault(",".join(metrics), []).append(start)
        bare = scene.removeprefix(solver).removeprefix("/")
        lines += [" ".join([metrics, bare, *found]) for metrics, found in alike.items()]
    return "\n".join(lines) + "\n"


def write(solver: str, failed: Iterable[tuple[str, str]]) -> Path:
    """Rewrite the list of a solver, reasons as they are. Raises `KeyError` for a metric without a reason."""
    reasons = _read(solver)[0]
    kept = list(failed)
    for _, metric in kept:
        reasons[metric]  # every class of failure has its reason, or is none that may be kept
    path = Path(str(files(__package__).joinpath(f"expected_{solver}.txt")))
    write_pieces(path, [text_of(solver, reasons, kept).encode()])
    _read.cache_clear()
    return path
