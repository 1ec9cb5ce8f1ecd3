"""`strandcli claims`: what the thesis claims, measured."""

from __future__ import annotations

import csv
import io
import statistics
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from . import options
from .progress import Talk

FILES = ("claims.csv", "claims.svg")
HEADS = {"claim": "claim", "source": "source's figure", "ours": "ours"}


@click.command()
@click.option("-o", "--output", type=options.PathType(), metavar="DIR", help="Also write claims.csv and claims.svg.")
@click.option(
    "--repeats", type=options.Whole(1, 100), default=5, show_default=True, metavar="N",
    help="How often times are measured; their median counts, and their spread is reported.",
)  # fmt: skip
@options.threads
@options.overwrite
@options.talk("Say what is compiled, where stderr is no terminal too.")
def command(output: Path | None, repeats: int, threads: int | None, overwrite: bool, talk: Talk) -> None:
    """Measure what the thesis claims and print each claim, the source's figure and ours."""
    from ..output.files import prepare_folder, write_pieces

    if output is not None:
        for name in FILES:
            options.refuse_existing(output / name, overwrite)
        prepare_folder(output, 0)
    with talk.compiled(1, "claims", threads) as progress:
        from ..study import claims

        data = claims.run(threads=threads, notify=progress.note, repeats=repeats)
    if output is not None:
        for name, text in zip(FILES, (to_csv(data["claims"]), claims.chart(data["claims"])), strict=True):
            write_pieces(output / name, [text.encode()])
    talk.result(data, lambda: table(data["claims"]))
    talk.warn_if_busy(data["busy"], "repeat this when it is idle")


def to_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """A row a claim: the source's figure, and the median, least and greatest of ours."""
    out = io.StringIO()
    lines = csv.writer(out, lineterminator="\n")
    lines.writerow(("claim", "source", "quantity", "median", "least", "greatest", "repeats"))
    for row in rows:
        values = row["values"]
        measured = (statistics.median(values), min(values), max(values), len(values))
        lines.writerow((row["claim"], row["source"], row["quantity"], *measured))
    return out.getvalue()


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Three columns, of which long entries go on below."""
    widths = {"claim": 44, "source": 24, "ours": 40}
    lines = ["  ".join(f"{HEADS[name]:<{width}}" for name, width in widths.items()).rstrip()]
    for row in rows:
        cells = [textwrap.wrap(str(row[name]), width) or [""] for name, width in widths.items()]
        for number in range(max(len(cell) for cell in cells)):
            parts = [cell[number] if number < len(cell) else "" for cell in cells]
            lines.append(
                "  ".join(f"{part:<{width}}" for part, width in zip(parts, widths.values(), strict=True)).rstrip()
            )
    return "\n".join(lines)
