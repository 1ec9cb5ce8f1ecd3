"""A study's figures as text: a table for people, and CSV."""

from __future__ import annotations

import csv
import io
import math
from typing import Any

from .chart import order_words, seconds, share, step
from .points import Knobs, by_line
from .sweep import Study

HEADS = {
    "emitter.particles": "particles",
    "time.substeps": "substeps",
    "rod.iterations": "iterations",
    "dt": "step",
    "emitter.strands": "guides",
    "children.count": "each for",
    "rules.interaction.cell": "cell",
}
MOST_METRICS = 6
"""Columns of errors in the table for people; the files hold all."""


def to_csv(study: Study) -> str:
    """A row a point: its knobs, step, seconds, every error, and whether it is on the front."""
    knobs = list(dict.fromkeys(name for point in study.points for name in point.knobs if name != "dt"))
    metrics = list(dict.fromkeys(name for point in study.points for name in point.error))
    counts = list(dict.fromkeys(name for point in study.points for name in point.counts))
    steps = ["dt"] if any("dt" in point.sizes for point in study.points) or not study.points else []
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*knobs, *steps, "seconds", *metrics, *counts, "pareto"])
    for point in study.points:
        writer.writerow(
            [
                *[point.knobs.get(name, "") for name in knobs],
                *[point.sizes.get(name, "") for name in steps],
                point.seconds,
                *["" if point.error.get(name) is None else point.error[name] for name in metrics],
                *[point.counts.get(name, "") for name in counts],
                int(point.pareto),
            ]
        )
    return out.getvalue()


def to_text(study: Study) -> str:
    """The table for people, then what follows from it."""
    lines = [study.title, f"errors are shares {study.unit}; settings are chosen by {study.metric}", ""]
    lines += _known(study)
    if study.points:
        lines += [*_rows(study), "", "* on the Pareto front: nothing measured is both as fast and as right"]
    for line in by_line(study.points):
        for metric in dict.fromkeys(one["metric"] for one in study.orders):
            words = order_words(study.orders, line, metric)
            if metric == study.metric:
                lines += [f"{line}: {', '.join(words)}"] if words else []
            elif any(not text.startswith("no") for text in words):
                lines.append(f"{' ' * len(line)}  {', '.join(w for w in words if not w.startswith('no'))}: {metric}")
    lines += [f"{one['solver']}: {one['why']}" for one in study.absent]
    lines += _advice(study)
    return "\n".join(lines)


def _known(study: Study) -> list[str]:
    what = study.reference.get("what")
    if what:
        return [f"reference: {what}", ""]
    exact = study.reference.get("exact")
    if exact:
        return [f"exact: {', '.join(f'{name} {value:.6g}' for name, value in exact.items())}", ""]
    out = []
    for name, limit in study.reference.get("limits", {}).items():
        sure = share(limit["uncertainty"]) if math.isfinite(limit["uncertainty"]) else "nothing"
        order = "" if limit["order"] is None else f", order {limit['order']:.1f}"
        drift = share(limit["gaps"][1]) if math.isfinite(limit["gaps"][1]) else "everything"
        words = f"known to {sure}" if limit["converges"] else f"none seen: the last refinement moved strands by {drift}"
        apart = limit.get("from_own_solver")
        far = f"; {share(apart)} from that of the preset's own solver" if apart else ""
        out.append(f"limit of {name}: {words}{order}{far}")
    return [*out, ""] if out else []


def _rows(study: Study) -> list[str]:
    known = ("solver", *HEADS)
    found = dict.fromkeys(name for point in study.points for name in point.knobs)
    knobs = [name for name in ("solver", *HEADS) if name in found] + [name for name in found if name not in known]
    metrics = list(dict.fromkeys(name for point in study.points for name in point.error))
    metrics = [study.metric, *[name for name in metrics if name != study.metric]][:MOST_METRICS]
    table = [["", *[HEADS.get(name, name) for name in knobs], "time", *metrics]]
    for point in study.points:
        row = ["*" if point.pareto else ""]
        row += [step(point.knobs["dt"]) if name == "dt" and "dt" in point.knobs else _cell(point.knobs.get(name))
                for name in knobs]  # fmt: skip
        row.append(seconds(point.seconds))
        for name in metrics:
            value = point.error.get(name)
            row.append(cell(name, value))
        table.append(row)
    widths = [max(len(row[i]) for row in table) for i in range(len(table[0]))]
    left = 2  # the mark and the solver's name stand to the left of their columns
    return [
        "  ".join(
            cell.ljust(width) if i < left else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in table
    ]


def _cell(value: Any) -> str:
    return "-" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def cell(metric: str, value: float | None) -> str:
    """An error for people: a share, or pixels where the metric's name ends so."""
    if value is None:
        return "-"
    return f"{value:.3g}" if metric.endswith(" px") else share(value)


def _advice(study: Study) -> list[str]:
    lines = [""] if study.recommended else []
    for one in study.recommended:
        margin = f", with the limit known to {share(one['margin'])}" if one["margin"] else ""
        lines.append(
            f"under {share(one['max_error'])}: {setting(one['knobs'])} in {seconds(one['seconds'])} "
            f"(error {share(one['error'])}{margin})"
        )
    return lines


def setting(knobs: Knobs) -> str:
    """A setting as it is written after `--set`."""
    return " ".join(f"step {step(value)}" if name == "dt" else f"{name}={value}" for name, value in knobs.items())
