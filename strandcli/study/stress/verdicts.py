"""What each metric may be, and what comes of it: pass, expected_failure, fail or not_represented.

The limits are those of the solver's design. A failure is expected only by name and with its reason, in
``expected_SOLVER.txt``: a reason for each metric (``@metric reason``), then a line for each scene: the metrics that
fail, the scene's name, and the starts from which they do.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any

from .axes import Case

LIMITS: dict[str, tuple[str, float, str]] = {
    "nonfinite": ("<=", 0.0, "strands and steps with NaN or infinity"),
    "moved_by_nothing": ("<=", 0.0, "a step of no length moves something"),
    "stretch": ("<=", 1e-6, "error of a segment's length, over rounding"),
    "residual": ("<=", 1e-3, "error of lengths before they are made exact"),
    "stopped": ("<=", 0.0, "a run would stop here, lengths off by a segment"),
    "penetration": ("<=", 1e-6, "depth in a sphere, L, over rounding"),
    "segment_penetration": ("<=", 0.02, "depth of whole segments in a sphere, L"),
    "overlap": ("", 0.0, "depth in overlapping spheres, L"),
    "pinned_off": ("<=", 1e-3, "distance of pinned tips from their places, L"),
}
"""By metric: how it compares with which limit ("" is reported and not judged), and what it is."""
WORDS = ("pass", "expected_failure", "fail", "not_represented")
RESIDUAL_WITHIN = "has a limit in steps of at most 1/24 s and up to 32 segments; lengths are made exact after it"
PINNED_WITHIN = "has a limit where nothing is in a strand's way and its pull moves no tip in a step"
FALL = 100.0
"""Ways that a strand would fall in a step, L, beyond which its pull moves a pinned tip, whose mass is finite."""
START, STRAIGHT = "/start=", "straight"


@dataclass
class Verdict:
    """One case's outcome, judged. ``failed`` are the metrics beyond their limits, ``unjudged`` those that have no limit
    in this case, with the reasons."""

    name: str
    parameters: Mapping[str, Any]
    metrics: Mapping[str, float]
    verdict: str
    why: str = ""
    failed: tuple[str, ...] = ()
    unjudged: Mapping[str, str] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """For JSON, numbers to four digits."""
        return {
            "name": self.name,
            "parameters": dict(self.parameters),
            "metrics": {key: float(f"{value:.4g}") for key, value in self.metrics.items()},
            "verdict": self.verdict,
            "why": self.why,
        }


def unjudged_of(case: Case) -> dict[str, str]:
    """What of a case no limit holds to, and why: the residual of long steps and of long strands, and how far pinned
    tips are that something pushes or pulls too hard."""
    step = case.value("dt") / case.value("substeps")
    found = {} if step <= 1 / 24 and case.value("n") <= 32 else {"residual": RESIDUAL_WITHIN}
    pushed = case.label("contact") != "none" or case.label("between") != "none"
    pull = case.value("gamma") * (case.value("B") or 1.0)
    if pushed or step > 1 / 24 or pull * step**2 > FALL:
        found["pinned_off"] = PINNED_WITHIN
    return found


def beyond(metric: str, value: float) -> bool:
    """Whether a metric is beyond its limit; NaN always is."""
    word, limit, _ = LIMITS[metric]
    return word != "" and not value <= limit


def judge(
    name: str, parameters: Mapping[str, Any], metrics: Mapping[str, float], error: str = "",
    unjudged: Mapping[str, str] | None = None, absent: str = "",
) -> Verdict:  # fmt: skip
    """The verdict on what was measured. ``unjudged`` metrics are only reported; the reasons given stand in a case that
    passed where they are beyond their limits. ``absent``: why the solver does not represent what the case is about."""
    if absent:
        return Verdict(name, parameters, metrics, "not_represented", absent)
    unjudged = unjudged or {}
    failed = tuple(key for key, value in metrics.items() if key not in unjudged and beyond(key, value))
    if error:
        failed = (*failed, "exception")
    if not failed:
        over = [key for key in metrics if key in unjudged and beyond(key, metrics[key])]
        why = "; ".join(f"{_words(key, metrics[key], 'not held to')}: {unjudged[key]}" for key in over)
        return Verdict(name, parameters, metrics, "pass", why, unjudged=unjudged)
    listed = expected(name.partition("/")[0])[1]
    reasons = {key: listed.get((name, key), "") for key in failed}
    if all(reasons.values()):
        why = "; ".join(dict.fromkeys(reasons.values()))
        return Verdict(name, parameters, metrics, "expected_failure", why, failed, unjudged)
    words = [error if key == "exception" else _words(key, metrics[key]) for key in failed if not reasons[key]]
    return Verdict(name, parameters, metrics, "fail", "; ".join(words), failed, unjudged)


def _words(metric: str, value: float, must: str = "must be") -> str:
    word, limit, _ = LIMITS[metric]
    return f"{metric} {value:.3g}, {must} {word} {limit:g}"


@cache
def expected(solver: str) -> tuple[dict[str, str], dict[tuple[str, str], str]]:
    """Reasons by metric, and the failures that are listed: (name, metric) with its reason."""
    path = files(__package__).joinpath(f"expected_{solver}.txt")
    reasons: dict[str, str] = {}
    listed: dict[tuple[str, str], str] = {}
    for line in path.read_text(encoding="utf-8").splitlines() if path.is_file() else ():
        if line.startswith("@"):
            metric, _, reason = line[1:].partition(" ")
            reasons[metric] = reason
        elif line and not line.startswith("#"):
            metrics, scene, *starts = line.split(" ")
            for start in starts:
                name = scene if start == STRAIGHT else scene + START + start
                for metric in metrics.split(","):
                    listed[f"{solver}/{name}".rstrip("/"), metric] = reasons[metric]
    return reasons, listed


def passed_after_all(solver: str, failed: Iterable[tuple[str, str]], ran: Iterable[str]) -> list[str]:
    """Names of cases that ran, and failed in less than what is listed for them."""
    happened, seen = set(failed), set(ran)
    return sorted({name for name, metric in expected(solver)[1] if name in seen and (name, metric) not in happened})
