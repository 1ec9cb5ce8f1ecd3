"""Pages of studies, of the stability matrix, and of sweeps."""

from __future__ import annotations

import csv
import re
import urllib.parse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..common.counted import counted
from ..output.files import write_pieces
from . import page, pictures, svg
from .run import FILE, cell

if TYPE_CHECKING:
    from ..study.stress.run import Result
    from ..study.sweep import Study

MOST_ROWS, MOST_SWEPT = 400, 1000
"""Of a table, and of that of a sweep; the files beside have all."""
MOST_PICTURES, BYTES = 48, 900_000
"""Of a sweep, and of all its pictures."""


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


def write_sweep(
    folder: Path, name: str, entries: Sequence[Mapping[str, Any]], head: Sequence[str], rows: Sequence[Sequence[Any]]
) -> Path:
    """Write the page beside the points' folders, whole or not at all. ``entries``: a mapping a point; ``head`` and
    ``rows``: the table."""
    failed = [one for one in entries if one["status"] != "complete"]
    axes = " × ".join(f"{key} ({len({one['settings'][key] for one in entries})})" for key in entries[0]["settings"])
    drawn = pictures.chosen([one for one in entries if one["last_frame"]], MOST_PICTURES)
    cells = [_cell(folder, one, BYTES // len(drawn)) for one in drawn]
    more = f"<p>{len(drawn)} of {counted(len(entries), 'run')}</p>" if len(drawn) < len(entries) else ""
    shown = [one not in ("folder", "last_frame", "pixels_sha256") for one in head]
    table = [[value for value, keep in zip(row, shown, strict=True) if keep] for row in rows[:MOST_SWEPT]]
    heads = [one for one, keep in zip(head, shown, strict=True) if keep]
    numbers = [i for i in range(len(heads)) if all(_is_number(row[i]) for row in table)]
    path = folder / FILE
    write_pieces(path, [page.page(f"{name}, a sweep: strandcli", [
        page.header(f"{name}, a sweep", f"{len(failed)} went wrong" if failed else "complete",
                    "bad" if failed else "", f"{counted(len(entries), 'run')} · {axes}"),
        page.section("Last frames", f'<div class="sheet">{"".join(cells)}</div>{more}' if cells else ""),
        page.section("Table", page.table(table, [one.replace("_", " ") for one in heads], numbers)),
        page.footer(__version__),
    ])])  # fmt: skip
    return path


def _cell(folder: Path, entry: Mapping[str, Any], most_bytes: int) -> str:
    """A picture that leads to the page of its run."""
    words = ", ".join(f"{key} = {value}" for key, value in entry["settings"].items())
    inner = cell(folder / entry["folder"] / entry["last_frame"], words, most_bytes)
    return f'<a href="{page.text(urllib.parse.quote(entry["folder"]))}/{FILE}">{inner}</a>'


def _is_number(value: Any) -> bool:
    try:
        float(value)
    except (TypeError, ValueError):
        return value == ""
    return True
