"""The whole of it: which cases, on how many processes, and the report that comes of them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

from ...compiling import runtime
from . import drive, matrix, verdicts
from .axes import AXES, SOLVERS, Case, case_named
from .verdicts import WORDS, Verdict, judge, unjudged_of

Notify = Callable[[str], None]
Task = tuple[Case, ...]
"""A piece of work: a batch of cases that differ in the start alone."""
CHUNK = 6
"""Tasks that a process is handed at once."""
MASSLESS = "its particles have no mass"


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
        failed = [(one.name, metric) for one in self.verdicts for metric in one.failed]
        ran = [one.name for one in self.verdicts]
        return [name for solver in self.solvers for name in verdicts.passed_after_all(solver, failed, ran)]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "solver": ",".join(self.solvers),
            "cases": [one.as_dict() for one in self.verdicts],
            "summary": self.summary,
            "passed_after_all": self.passed_after_all,
            "seconds": round(self.seconds, 1),
        }


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
    step: Callable[[int], None] | None = None,
    tell: Callable[[Verdict], None] | None = None,
) -> Result:
    """Judge the cases of ``work``, those alone whose name ``only`` accepts; ``step`` gets how many more are done,
    ``tell`` each verdict."""
    began = time.perf_counter()
    accept = only or (lambda name: True)
    wanted = [task for task in work if any(accept(case.name) for case in task)]
    found: list[Verdict] = []
    for several in _results(wanted, processes, notify):
        kept = [one for one in several if accept(one.name)]
        found += kept
        if tell is not None:
            for one in kept:
                tell(one)
        if step is not None:
            step(len(kept))
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
    """End this process when the one that began it has ended, however: where that was killed nobody says so, and a
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
