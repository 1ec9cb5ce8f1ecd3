"""`strandcli claims`: what the thesis claims, measured."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import click

from . import options
from .progress import Progress
from .say import say

HEADS = {"claim": "claim", "source": "source's figure", "ours": "ours"}


@click.command()
@options.threads
@options.talk("Say what is compiled, where stderr is no terminal too.")
def command(threads: int | None, as_json: bool, quiet: bool, verbose: bool, no_progress: bool) -> None:
    """Measure what the thesis claims and print each claim, the source's figure and ours."""
    from .. import runtime

    with Progress(1, "claims", hidden=no_progress or quiet, verbose=verbose) as progress:
        runtime.start(threads, progress.note)
        from ..study import claims

        data = claims.run(threads=threads, notify=progress.note)
    if as_json:
        options.print_json(data)
    elif not quiet:
        say(table(data["claims"]))


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
