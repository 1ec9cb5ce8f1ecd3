"""Pages of studies and of the stability matrix."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..common.counted import counted
from . import page, svg

if TYPE_CHECKING:
    from ..study.stress.run import Result
    from ..study.sweep import Study

MOST_ROWS = 400
"""Of a table; the files beside have all."""


def of_study(study: Study, max_error: float | None, machine: Mapping[str, Any]) -> bytes:
    """The page of a study: its chart, what it recommends, and all points."""
    from ..study.chart import chart
    from ..study.report import to_csv, to_text

    missed = max_error is not None and bool(study.points) and not study.recommended
    rows = list(csv.reader(to_csv(study).splitlines()))
    numbers = [i for i, name in enumerate(rows[0]) if name != "solver"]
    shown = [[_short(cell) for cell in row] for row in rows[1 : MOST_ROWS + 1]]
    drawing = chart(study, max_error)
    return page.page(f"{study.title}: strandcli", [
        page.header(study.title, "no setting is below it" if missed else "measured", "bad" if missed else "",
                    f"error: {study.metric}, a share {study.unit}"),
        page.section("Error against run time", re.sub(r"^<svg ", '<svg class="plain" ', drawing)),
        page.section("In words", f"<pre>{page.lines(to_text(study))}</pre>"),
        page.section("All points", page.table(shown, rows[0], numbers)),
        page.section("Machine", page.table([(key.replace("_", " "), one) for key, one in machine.items()])),
        page.footer(__version__),
    ])  # fmt: skip


def of_stress(result: Result, words: str) -> bytes:
    """The page of a stability matrix; ``words``: its table for people."""
    failed = [one for one in result.verdicts if one.verdict == "fail"]
    counts = {word: count for word, count in result.summary.items() if count}
    named = [[one.name, one.verdict.replace("_", " "), one.why] for one in result.verdicts if one.verdict != "pass"]
    bars = svg.bars([(word.replace("_", " "), count, f"{count:,}") for word, count in counts.items()])
    return page.page("Stability: strandcli", [
        page.header(f"Stability of {' and '.join(result.solvers)}", f"{len(failed):,} failed" if failed else "passed",
                    "bad" if failed else "", f"{counted(len(result.verdicts), 'case')} in {result.seconds:.0f} s"),
        page.section("Failed", page.table([(one.name, one.why) for one in failed[:MOST_ROWS]]), "note"),
        page.section("Verdicts", bars),
        page.section("Worst cases", f"<pre>{page.lines(words)}</pre>"),
        page.section("Cases that are no plain pass", page.table(named[:MOST_ROWS], ("case", "verdict", "why"))),
        page.footer(__version__),
    ])  # fmt: skip


def _short(cell: str) -> str:
    """A number with four digits."""
    return f"{float(cell):.4g}" if re.fullmatch(r"-?[0-9.]+(e[-+]?[0-9]+)?", cell) and "." in cell else cell
