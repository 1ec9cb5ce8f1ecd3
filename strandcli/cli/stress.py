"""`strandcli stress`: the stability matrix, with a verdict on every case."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from ..common.counted import counted
from ..common.limits import cores
from ..errors import MismatchError, UsageError
from . import options
from .progress import Talk, print_json, say

if TYPE_CHECKING:
    from ..study.stress.run import Result, Verdict

MOST_TOLD = 20
"""Failing cases that are named one by one; --json has all."""


@click.command()
@click.option("--solver", type=click.Choice(("rod", "thesis", "both")), help="Solver to test.  [default: both]")
@click.option("--case", "case", metavar="NAME", help="Run this case alone, as the table and --json name it.")
@click.option("--filter", "pattern", metavar="WORDS", help="Run the cases whose name has all of WORDS; or a pattern.")
@click.option("--list", "listing", is_flag=True, help="Name the cases and run nothing.")
@click.option("--quick", is_flag=True, help="The small matrix, of a few seconds.")
@options.threads
@options.talk("Name each case as it fails, and what is compiled.")
def command(
    solver: str | None, case: str | None, pattern: str | None, listing: bool, quick: bool, threads: int | None,
    talk: Talk,
) -> None:  # fmt: skip
    """Run the solvers through every extreme of step, stiffness, weight, wind, motion, contact and start.

    Exit code 3 where a case fails that was not expected to; --case NAME runs one case again.
    """
    if pattern is not None and not pattern.strip():
        raise UsageError("--filter: the text is empty; leave it out to run all cases")
    from ..output.report import finite
    from ..study.stress import run as stress

    if case is not None:
        work = [stress.named(case)]
        own = stress.case_named(case).name  # axes in their order, without defaults
    else:
        work = stress.tasks(("rod", "thesis") if solver in (None, "both") else (str(solver),), quick)
    accept = stress.matching(pattern) if pattern else lambda name: True
    only = accept if case is None else lambda name: name == own
    names = [one.name for task in work for one in task if only(one.name)]
    if not names:
        raise UsageError(f"--filter {pattern}: no case has such a name; --list names them all")
    if listing:
        say("\n".join(names))
        return
    with talk.progress(len(names), "stress", each="case", lines=len(names) > 1) as progress:

        def done(several: Sequence[Verdict]) -> None:
            progress.step(count=len(several))
            for one in several:
                if talk.verbose and one.verdict == "fail":
                    progress.line(f"failed: {one.name}: {one.why}")

        result = stress.run(work, only=only, processes=threads or cores(), notify=progress.note, done=done)
    if talk.as_json:
        print_json(finite(result.as_dict()))
    elif case and not talk.quiet:
        say("\n".join(detail(one) for one in result.verdicts))
    elif not talk.quiet:
        say(table(result))
    failed = [one for one in result.verdicts if one.verdict == "fail"]
    if failed:
        first = f"{failed[0].name}: {failed[0].why}"
        more = "" if case else f"; again with: strandcli stress --case {failed[0].name}"
        raise MismatchError(f"{len(failed)} of {counted(len(result.verdicts), 'case')} failed, such as {first}{more}")


def detail(verdict: Verdict) -> str:
    """One case for people."""
    lines = [f"{verdict.name}: {verdict.verdict}" + (f" ({verdict.why})" if verdict.why else "")]
    lines += [f"  {name:<20}{value:>14.4g}" for name, value in verdict.metrics.items()]
    return "\n".join(lines)


def table(result: Result) -> str:
    """A row for each solver and metric with its worst case, then the failures by name, then how many of what."""
    from ..study.stress.run import LIMITS

    head = ("solver", "metric", "must be", "worst", "cases", "beyond")
    lines = ["{:<8}{:<20}{:>10}{:>11}{:>8}{:>8}  worst case, and what it is".format(*head)]
    for solver in result.solvers:
        mine = [one for one in result.verdicts if one.name.partition("/")[0] == solver]
        for metric, (word, limit, _) in LIMITS.items():
            for reported in (False, True):
                must = f"{word} {limit:g}" if word and not reported else "reported"
                lines += _row(solver, metric, must, [one for one in mine if (metric in one.unjudged) == reported])
        ended = [one for one in mine if "exception" in one.failed]
        lines.append(f"{solver:<8}{'exception':<20}{'none':>10}{'':>11}{len(mine):>8,}{len(ended):>8,}")
    failed = [one for one in result.verdicts if one.verdict == "fail"]
    if failed:
        lines += ["", "failed:"] + [f"  {one.name}: {one.why}" for one in failed[:MOST_TOLD]]
        if len(failed) > MOST_TOLD:
            lines.append(f"  and {len(failed) - MOST_TOLD:,} more, which --json names")
    over = {
        (metric, one.unjudged[metric]) for one in result.verdicts for metric in one.unjudged if metric in one.metrics
    }
    if over:
        lines += ["", "reported and not judged:", *(f"  {metric}: {reason}" for metric, reason in sorted(over))]
    absent = [one for one in result.verdicts if one.verdict == "not_represented"]
    if absent:
        reasons = dict.fromkeys(f"  {one.name.partition('/')[0]}: {one.why}" for one in absent)
        lines += ["", "not represented:", *reasons]
    counts = ", ".join(f"{count:,} {word.replace('_', ' ')}" for word, count in result.summary.items())
    lines += ["", f"{counts}; {counted(len(result.verdicts), 'case')} in {result.seconds:.0f} s"]
    better = result.passed_after_all
    if better:
        lines.append(f"{len(better)} were listed to fail and did not, or in less, such as {better[0]}")
    return "\n".join(lines)


def _row(solver: str, metric: str, must: str, cases: Sequence[Verdict]) -> list[str]:
    """The table's row of a metric in those of some cases that have it; none where none has."""
    from ..study.stress.run import LIMITS

    meaning = LIMITS[metric][2]
    known = [(one.metrics[metric], one) for one in cases if metric in one.metrics]
    if not known:
        return []
    value, worst = max(known, key=lambda pair: pair[0] if pair[0] == pair[0] else float("inf"))  # NaN is the worst
    beyond = sum(metric in one.failed for _, one in known)
    return [f"{solver:<8}{metric:<20}{must:>10}{value:>11.3g}{len(known):>8,}{beyond:>8,}  {worst.name}  ({meaning})"]
