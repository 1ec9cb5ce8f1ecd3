"""The stability matrix, run on several processes and judged: pass, expected_failure, fail or not_represented.

The limits are those of the solver's design. A failure is expected only by name and with its reason, in
``expected_SOLVER.txt``: a reason for each metric (``@metric reason``), then a line for each scene: the metrics that
fail, the scene's name, and the starts from which they do.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cache
from importlib.resources import files
from typing import Any

from ...compiling import runtime
from . import drive, matrix
from .matrix import AXES, SOLVERS, Case, case_named

Notify = Callable[[str], None]
Task = tuple[Case, ...]
"""A piece of work: a batch of cases that differ in the start alone."""
CHUNK = 6
"""Tasks that a process is handed at once."""
MASSLESS = "its particles have no mass"
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
"""Distance that a strand would fall in a step, L, beyond which its pull moves a pinned tip, whose mass is finite."""
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
            "name": self.name, "parameters": dict(self.parameters),
            "metrics": {key: float(f"{value:.4g}") for key, value in self.metrics.items()}, "verdict": self.verdict,
            "why": self.why,
        }  # fmt: skip


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


@dataclass
class Result:
    """All verdicts, in the order of the cases."""

    solvers: tuple[str, ...]
    verdicts: list[Verdict]
    seconds: float

    @property
    def summary(self) -> dict[str, int]:
        """How many of each verdict."""
        return {word: sum(one.verdict == word for one in self.verdicts) for word in WORDS}

    @property
    def passed_after_all(self) -> list[str]:
        """Cases that were listed to fail, and did not or in less."""
        failed = {one.name: one.failed for one in self.verdicts}
        listed = [case for solver in self.solvers for case in expected(solver)[1]]
        return sorted({name for name, metric in listed if name in failed and metric not in failed[name]})

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "solver": ",".join(self.solvers), "cases": [one.as_dict() for one in self.verdicts],
            "summary": self.summary, "passed_after_all": self.passed_after_all, "seconds": round(self.seconds, 1),
        }  # fmt: skip


def tasks(solvers: Sequence[str], quick: bool = False) -> list[Task]:
    """The matrix of some solvers as pieces of work."""
    take = matrix.quick if quick else matrix.full
    return [batch for solver in solvers for batch in matrix.batches(take(solver))]


def named(name: str) -> Task:
    """The piece of work that a single case is replayed by. Raises `UsageError` where nothing has this name."""
    case = case_named(name)
    if case.grouped or case.value("strands") > 1:
        return (case,)
    # a strand's neighbours decide when its block stops iterating: the same ones give the same bits
    return tuple(case.with_labels(start=start) for start in AXES["start"])


def run(
    work: Sequence[Task],
    *,
    only: Callable[[str], bool] | None = None,
    processes: int = 1,
    notify: Notify | None = None,
    done: Callable[[Sequence[Verdict]], None] = lambda verdicts: None,
) -> Result:
    """Judge the cases of ``work``, those alone whose name ``only`` accepts; ``done`` gets verdicts as they come."""
    began = time.perf_counter()
    accept = only or (lambda name: True)
    wanted = [task for task in work if any(accept(case.name) for case in task)]
    found: list[Verdict] = []
    for several in _results(wanted, processes, notify):
        accepted = [one for one in several if accept(one.name)]
        found += accepted
        done(accepted)
    solvers = tuple(solver for solver in SOLVERS if any(solver == one.name.partition("/")[0] for one in found))
    return Result(solvers, found, time.perf_counter() - began)


def matching(pattern: str) -> Callable[[str], bool]:
    """Whether a name holds the words of a filter, or matches it where it has wildcards."""
    if any(sign in pattern for sign in "*?["):
        return lambda name: fnmatchcase(name, pattern)
    return lambda name: all(word in name for word in pattern.split())


def _results(work: Sequence[Task], processes: int, notify: Notify | None) -> Iterator[list[Verdict]]:
    runtime.start(1, notify)
    if processes <= 1 or len(work) < 4 * CHUNK:
        yield from map(perform, work)
        return
    # what has to be compiled is compiled once, here, and read from the cache by the processes
    for task in _one_of_each(work):
        perform(task)
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, fresh, initializer=_begin) as pool:
        try:
            yield from pool.map(perform, work, chunksize=CHUNK)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def _begin() -> None:
    """What a process does first: one thread, and an interruption is its parent's to handle."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    runtime.start(1)


def _end_with_parent() -> None:
    """End this process when the one that began it has ended, however: where that was killed it cannot say so, and a
    process that is handed no more work waits for it for good."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _one_of_each(work: Iterable[Task]) -> list[Task]:
    """A task for every kernel that the work needs."""
    found: dict[Any, Task] = {}
    for task in work:
        case = task[0]
        free = case.label("contact") == "none" or case.solver == "thesis"
        found.setdefault((case.solver, case.value("n") > 10, free, *case.value("between")), task)
    return list(found.values())


def perform(task: Task) -> list[Verdict]:
    """Verdicts on one piece of work."""
    if task[0].solver == "thesis" and task[0].label("tip") != "1":
        return [judge(case.name, case.parameters, {}, absent=MASSLESS) for case in task]
    return [
        judge(one.case.name, one.case.parameters, one.metrics, one.error, unjudged_of(one.case))
        for one in drive.run(task)
    ]
