"""What each metric may be, and what comes of it: pass, expected_failure, fail or not_represented.

The thresholds are those of the solver's design: of lengths, contact and iterations for every scene of the matrix, of
physics for the checks made for them. Nobody's failure is expected but by name and with its reason (`expected`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from . import expected
from .axes import Case

RESIDUAL = 1e-3

LIMITS: dict[str, tuple[str, float]] = {
    "nonfinite": ("<=", 0.0),
    "moved_by_nothing": ("<=", 0.0),
    "stretch": ("<=", 1e-6),
    "residual": ("<=", RESIDUAL),
    "stopped": ("<=", 0.0),
    "penetration": ("<=", 1e-6),
    "segment_penetration": ("<=", 0.02),
    "overlap": ("", 0.0),
    "stretch_double": ("<=", 1e-12),
    "energy_growth": ("<=", 1e-6),
    "amplitude_kept": (">=", 0.999),
    "rest_motion": ("<=", 1e-6),
    "rest_motion_contact": ("<=", 1e-3),
    "rest_24_240": ("<=", 1e-4),
    "rest_substeps": ("<=", 1e-4),
    "droop_soft": ("<=", 0.015),
    "droop_10": ("<=", 0.025),
    "droop_order": (">=", 1.8),
    "upright": ("<=", 0.02),
    "tilted": (">=", 0.1),
    "differences": ("<=", 0.0),
    "sag": ("<=", 1e-6),
    "sag_later": ("<=", 1e-6),
    "sag_regained": ("<=", 1e-4),
    "pinned_off": ("<=", 1e-3),
    "pinned_off_told": ("", 0.0),
    "energy_gained": ("<=", 0.01),
    "energy_gained_told": ("", 0.0),
    "closeness": ("", 0.0),
    "passed": ("<=", 0.0),
    "passed_told": ("", 0.0),
    "linking_changed": ("<=", 0.0),
    "refused": (">=", 1.0),
}
"""Metric: how it compares with which limit; "" is told and not judged."""

MEANING = {
    "nonfinite": "strands and steps with NaN or infinity",
    "moved_by_nothing": "a step of no length moves something",
    "stretch": "error of a segment's length, over rounding",
    "residual": "error of lengths before they are made exact",
    "stopped": "a run would stop here, lengths off by a segment",
    "penetration": "depth in a sphere, L, over rounding",
    "segment_penetration": "depth of whole segments in a sphere, L",
    "overlap": "depth in overlapping spheres, L",
    "stretch_double": "error of lengths in double precision",
    "energy_growth": "energy gained undamped, m g L",
    "amplitude_kept": "swing kept a cycle at 60 Hz",
    "rest_motion": "motion at rest over 1 s, L",
    "rest_motion_contact": "motion at rest in contact over 1 s, L",
    "rest_24_240": "rest tip, 24 against 240 Hz, L",
    "rest_substeps": "rest, substeps 1 against 8, L",
    "droop_soft": "droop against the elastica, gamma <= 1",
    "droop_10": "droop against the elastica, gamma 10",
    "droop_order": "order of droop in segments",
    "upright": "tip aside at gamma 7.7, L",
    "tilted": "tip aside at gamma 7.9, L",
    "differences": "bits that differ between runs or threads",
    "sag": "first frame's motion of a sag-free start, L",
    "sag_later": "most motion of a sag-free start in 96 steps, L",
    "sag_regained": "sag-free start after its root turned and back, L",
    "pinned_off": "distance of pinned tips from their places, L",
    "pinned_off_told": "the same in long steps, or with anything in the way, L",
    "energy_gained": "energy gained where only weight works, m g L",
    "energy_gained_told": "the same in long steps, m g L",
    "closeness": "strands closer than their thickness, over it",
    "passed": "segments that have passed through others in contact",
    "passed_told": "the same where strands begin inside each other",
    "linking_changed": "linked curves that have passed through each other",
    "refused": "bad input refused by name",
}

WORDS = ("pass", "expected_failure", "fail", "not_represented")


@dataclass
class Verdict:
    """One case's outcome, judged. ``failed`` are the metrics beyond their limits, ``told`` those that no limit of the
    case holds to, with the reasons."""

    name: str
    parameters: Mapping[str, Any]
    metrics: Mapping[str, float]
    verdict: str
    why: str = ""
    failed: tuple[str, ...] = ()
    told: Mapping[str, str] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """For JSON, numbers to four digits."""
        return {
            "name": self.name,
            "parameters": dict(self.parameters),
            "metrics": {key: float(f"{value:.4g}") for key, value in self.metrics.items()},
            "verdict": self.verdict,
            "why": self.why,
        }


RESIDUAL_WITHIN = "has a limit in steps of at most 1/24 s and up to 32 segments; lengths are made exact after it"


def told_of(case: Case) -> dict[str, str]:
    """What of a case no limit holds to, and why: the residual of long steps and of long strands."""
    within = case.value("dt") / case.value("substeps") <= 1 / 24 and case.value("n") <= 32
    return {} if within else {"residual": RESIDUAL_WITHIN}


def beyond(metric: str, value: float) -> bool:
    """Whether a metric is beyond its limit; NaN always is."""
    word, limit = LIMITS[metric]
    if word == "":
        return False
    return not (value <= limit if word == "<=" else value >= limit)


def judge(
    name: str, parameters: Mapping[str, Any], metrics: Mapping[str, float], error: str = "",
    unjudged: Mapping[str, str] | None = None, absent: str = "",
) -> Verdict:  # fmt: skip
    """The verdict on what was measured. ``unjudged`` metrics are told alone, for the reasons given, which a case that
    passed gives where they are beyond their limits; ``absent`` says why the solver does not represent what the case is
    about."""
    if absent:
        return Verdict(name, parameters, metrics, "not_represented", absent)
    unjudged = unjudged or {}
    failed = tuple(key for key, value in metrics.items() if key not in unjudged and beyond(key, value))
    if error:
        failed = (*failed, "exception")
    if not failed:
        over = [key for key in metrics if key in unjudged and beyond(key, metrics[key])]
        why = "; ".join(f"{_told(key, metrics[key], 'not held to')}: {unjudged[key]}" for key in over)
        return Verdict(name, parameters, metrics, "pass", why, told=unjudged)
    reasons = {key: expected.reason(name, key) for key in failed}
    if all(reasons.values()):
        why = "; ".join(dict.fromkeys(reasons.values()))
        return Verdict(name, parameters, metrics, "expected_failure", why, failed, unjudged)
    told = [error if key == "exception" else _told(key, metrics[key]) for key in failed if not reasons[key]]
    return Verdict(name, parameters, metrics, "fail", "; ".join(told), failed, unjudged)


def _told(metric: str, value: float, must: str = "must be") -> str:
    word, limit = LIMITS[metric]
    return f"{metric} {value:.3g}, {must} {word} {limit:g}"
