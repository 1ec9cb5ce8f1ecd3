"""The page of a sweep."""

from __future__ import annotations

import urllib.parse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from .. import __version__
from ..common.counted import counted
from ..output.files import write_pieces
from . import page, pictures
from .run import FILE, cell

MOST_ROWS = 1000
"""Of the table; the file beside has all."""
MOST_PICTURES, BYTES = 48, 900_000
"""Of a sweep, and of all its pictures."""


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
    table = [[value for value, keep in zip(row, shown, strict=True) if keep] for row in rows[:MOST_ROWS]]
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
