"""The chart of the thesis' claims as SVG: of each, the source's range, and our repeats."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from .chart import FAINT, GRID, INK, line, marker, text

WIDTH, TOP, ROW = 1080, 70.0, 44.0
LEFT, RIGHT = 560.0, 170.0
BAND, OURS = "#cfd8e3", "#d55e00"


def chart(rows: Sequence[Mapping[str, Any]]) -> str:
    """The text of an SVG file: a row a claim, on an axis of its own that begins at 0."""
    height = TOP + ROW * len(rows) + 20
    what = "grey: the source's range; dot: ours, the median; line: the least and the greatest of our repeats"
    items = [text((24, 26), "What the thesis claims, measured", INK, 19), text((24, 50), what, FAINT, 13)]
    for place, row in enumerate(rows):
        items += _row(row, TOP + ROW * (place + 0.5))
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height:g}" viewBox="0 0 {WIDTH} {height:g}" '
        'font-family="Helvetica, Arial, sans-serif">',
        '<rect width="100%" height="100%" fill="#ffffff"/>', *items, "</svg>", "",
    ])  # fmt: skip


def _row(row: Mapping[str, Any], y: float) -> list[str]:
    values, source = row["values"], row["range"] or []
    most = max(*values, *source, 1e-9)
    span = (WIDTH - LEFT - RIGHT) / (1.1 * most)
    x = [LEFT + span * value for value in (min(values), statistics.median(values), max(values))]
    items = [text((24, y), row["claim"], INK, 12), line([(LEFT, y), (WIDTH - RIGHT, y)], GRID)]
    if source:
        low, high = (LEFT + span * value for value in source)
        items.append(line([(low - 1, y), (high + 1, y)], BAND, 18))
    items += [line([(x[0], y), (x[2], y)], OURS, 3), marker("disc", (x[1], y), 5, OURS, "#ffffff")]
    return [*items, text((WIDTH - RIGHT + 10, y), f"{statistics.median(values):.3g} {row['quantity']}", INK, 12)]
