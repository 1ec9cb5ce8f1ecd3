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
from pathlib import Path
from typing import Any

from ... import runtime
from ...errors import UsageError
from ...scene.faults import hint
from . import checks, drive, expected, inputs, preset, sheets, together, traits
from .axes import AXES, SOLVERS, Case, case_named
from .strand import NotRepresented, Refused
from .task import Task
from .verdicts import WORDS, Verdict, judge, told_of

Notify = Callable[[str], None]
CHUNK = 12
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
        return [name for solver in self.solvers for name in expected.passed_after_all(solver, failed, ran)]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "solver": ",".join(self.solvers),
            "cases": [one.as_dict() for one in self.verdicts],
            "summary": self.summary,
            "passed_after_all": self.passed_after_all,
            "seconds": round(self.seconds, 1),
        }

    def accept(self) -> Path:
        """Keep the failures of the source's solver as those that are expected; returns the file written."""
        mine = [one for one in self.verdicts if one.name.partition("/")[0] == "thesis"]
        return expected.write("thesis", [(one.name, metric) for one in mine for metric in one.failed])


def tasks(solvers: Sequence[str], quick: bool = False, kinds: Sequence[str] = ()) -> list[Task]:
    """The matrix of some solvers as pieces of work; with ``kinds``, that of rods with these on in every case."""
    if kinds:
        return together.tasks(kinds, quick)
    found = []
    for solver in solvers:
        found += [Task(solver, named=name) for name in inputs.INPUTS]
        found += [Task(solver, named=name) for name in (checks.QUICK if quick else checks.CHECKS)]
        if solver == "rod":
            found += [Task(solver, named=name) for name in (traits.quick() if quick else traits.table())]
        cases: Sequence[Case] = sheets.quick(solver) if quick else sheets.full(solver)
        found += [Task(solver, tuple(batch)) for batch in sheets.batches(cases)]
    return found


def named(name: str) -> Task:
    """The piece of work that a single case is replayed by. Raises `UsageError` where nothing has this name."""
    solver, _, rest = name.partition("/")
    if rest.startswith(("check=", "input=")):
        known = [*checks.CHECKS, *inputs.INPUTS, *traits.table()]
        if solver not in SOLVERS:
            raise UsageError(f"--case {name}: begins with the solver; {hint(solver, SOLVERS, 'the solvers are')}")
        if rest not in known:
            begun = [one for one in known if one.startswith(rest)]
            raise UsageError(
                f"--case {name}: there is no such check; "
                + (f"there are {', '.join(begun)}" if begun else hint(rest, known, "they are"))
            )
        return Task(solver, named=rest)
    if together.has_own_axes(name):
        return together.named(name)
    case = case_named(name)
    if case.value("strands") > 1:
        return Task(solver, (case,))
    # a strand's neighbours decide when its block stops iterating: the same ones give the same bits
    return Task(solver, tuple(Case(solver, (*case.labels[:-1], start)) for start in AXES["start"]))


def canonical(name: str) -> str:
    """A case's name as it is listed: axes in their order, defaults left out."""
    return case_named(name).name


def run(
    work: Sequence[Task],
    *,
    only: Callable[[str], bool] | None = None,
    processes: int = 1,
    notify: Notify | None = None,
    step: Callable[[int], None] | None = None,
    tell: Callable[[Verdict], None] | None = None,
) -> Result:
    """Judge the cases of ``work``, those alone whose name ``only`` accepts; ``step`` is told how many more are done,
    ``tell`` each verdict."""
    began = time.perf_counter()
    accept = only or (lambda name: True)
    wanted = [task for task in work if any(accept(name) for name in task.names)]
    verdicts: list[Verdict] = []
    for found in _results(wanted, processes, notify):
        kept = [one for one in found if accept(one.name)]
        verdicts += kept
        if tell is not None:
            for one in kept:
                tell(one)
        if step is not None:
            step(len(kept))
    solvers = tuple(solver for solver in SOLVERS if any(task.solver == solver for task in wanted))
    return Result(solvers, verdicts, time.perf_counter() - began)


def matching(pattern: str) -> Callable[[str], bool]:
    """Whether a name holds the words of a filter, or matches it where it has wildcards."""
    if any(sign in pattern for sign in "*?["):
        return lambda name: fnmatchcase(name, pattern)
    return lambda name: all(word in name for word in pattern.split())


def _results(work: Sequence[Task], processes: int, notify: Notify | None) -> Iterator[list[Verdict]]:
    if processes <= 1 or len(work) < 4 * CHUNK:
        runtime.start(1, notify)
        yield from map(perform, work)
        return
    # what has to be compiled is compiled once, here, and read from the cache by the processes
    runtime.start(1, notify)
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
        if task.labels and task.cases:
            found.setdefault(together.kernels_of(task), task)
        elif task.cases:
            case = task.cases[0]
            kind = (task.solver, case.value("n") > 10, case.label("contact") == "none" or task.solver == "thesis")
            found.setdefault(kind, task)
    return list(found.values())


def perform(task: Task) -> list[Verdict]:
    """Verdicts on one piece of work."""
    if task.scene is not None:
        return [preset.perform(task)]
    if task.labels:
        return [together.perform(task)]
    if task.named:
        return [_named(task)]
    if task.solver == "thesis" and task.cases[0].label("tip") != "1":
        return [judge(case.name, case.parameters, {}, absent=MASSLESS) for case in task.cases]
    return [
        judge(one.case.name, one.case.parameters, one.metrics, one.error, told_of(one.case))
        for one in drive.run(task.cases)
    ]


def _named(task: Task) -> Verdict:
    name = f"{task.solver}/{task.named}"
    parameters = dict(part.partition("=")[::2] for part in task.named.split("/"))
    if task.named in inputs.INPUTS:
        told = inputs.INPUTS[task.named](task.solver)
        found = judge(name, parameters, {"refused": float(bool(told))})
        found.why = found.why or told
        return found
    try:
        metrics = {**checks.CHECKS, **traits.table()}[task.named](task.solver)
    except Refused as reason:
        found = judge(name, parameters, {"refused": 1.0})
        found.why = str(reason)
        return found
    except NotRepresented as reason:
        return judge(name, parameters, {}, absent=str(reason))
    except Exception as error:  # whatever a solver raises is what is looked for here
        return judge(name, parameters, {}, f"{type(error).__name__}: {error}")
    return judge(name, parameters, metrics)
