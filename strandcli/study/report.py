"""A study's figures as text: a table for people, CSV, and what to try."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from typing import Any

from .points import CELL, Parameters, by_line
from .sweep import Study

HEADS = {
    "emitter.particles": "particles",
    "time.substeps": "substeps",
    "rod.iterations": "iterations",
    "dt": "step",
    CELL: "cell",
}
MOST_METRICS = 6
"""Columns of errors in the table for people; the files hold all."""


def share(value: float) -> str:
    """A share for people: 0.01 is 1 %."""
    return f"{100 * value:.3g} %"


def seconds(value: float) -> str:
    """A run time for people."""
    return f"{value:.3g} s" if value >= 1 else f"{1e3 * value:.3g} ms"


def step(dt: float) -> str:
    """A step in seconds for people: 1/240 s."""
    per = 1 / dt
    return f"1/{round(per)} s" if per > 1.5 and abs(per - round(per)) < 1e-6 * per else f"{dt:.3g} s"


def setting(parameters: Parameters) -> str:
    """A setting as it is written after `--set`."""
    return " ".join(f"step {step(value)}" if name == "dt" else f"{name}={value}" for name, value in parameters.items())


def order_words(orders: Sequence[dict[str, Any]], line: str, metric: str) -> list[str]:
    """What is known of a line's orders of convergence in a metric."""
    names = {"dt": "Δt", "segment": "segment length"}
    found = []
    for one in orders:
        if (one["line"], one["metric"]) == (line, metric):
            order = "no order seen" if one["order"] is None else f"order {one['order']:.2f}"
            found.append(f"{order} in {names.get(one['in'], one['in'])}")
    return found


def columns(rows: Sequence[Sequence[str]], left: Sequence[int]) -> list[str]:
    """Lines of a table; the columns whose numbers are ``left`` are flush left, the rest right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            text.ljust(width) if i in left else text.rjust(width)
            for i, (text, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def to_csv(study: Study) -> str:
    """A row a point: its parameters, step, seconds, every error, and whether it is on the front."""
    parameters = list(dict.fromkeys(name for point in study.points for name in point.parameters if name != "dt"))
    metrics = list(dict.fromkeys(name for point in study.points for name in point.error))
    counts = list(dict.fromkeys(name for point in study.points for name in point.counts))
    steps = ["dt"] if any("dt" in point.sizes for point in study.points) or not study.points else []
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*parameters, *steps, "seconds", *metrics, *counts, "pareto"])
    for point in study.points:
        cells = [
            *(point.parameters.get(name) for name in parameters),
            *(point.sizes.get(name) for name in steps),
            point.seconds,
        ]
        cells += [*(point.error.get(name) for name in metrics), *(point.counts.get(name) for name in counts)]
        writer.writerow(["" if cell is None else cell for cell in cells] + [int(point.pareto)])
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
    lines += [""] if study.recommended else []
    for one in study.recommended:
        margin = f", with the limit known to {share(one['margin'])}" if one["margin"] else ""
        lines.append(
            f"under {share(one['max_error'])}: {setting(one['parameters'])} in {seconds(one['seconds'])} "
            f"(error {share(one['error'])}{margin})"
        )
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
        out.append(f"limit of {name}: {words}{order}")
    return [*out, ""] if out else []


def _rows(study: Study) -> list[str]:
    known = ("solver", *HEADS)
    found = dict.fromkeys(name for point in study.points for name in point.parameters)
    parameters = [name for name in known if name in found] + [name for name in found if name not in known]
    metrics = list(dict.fromkeys([study.metric, *(name for point in study.points for name in point.error)]))
    metrics = metrics[:MOST_METRICS]
    table = [["", *[HEADS.get(name, name) for name in parameters], "time", *metrics]]
    for point in study.points:
        row = [_cell(name, point.parameters.get(name)) for name in parameters]
        errors = [point.error.get(name) for name in metrics]
        row += [seconds(point.seconds), *("-" if error is None else share(error) for error in errors)]
        table.append(["*" if point.pareto else "", *row])
    return columns(table, (0, 1))  # the mark, and the solver's name


def _cell(name: str, value: Any) -> str:
    if value is None:
        return "-"
    return step(value) if name == "dt" else f"{value:.4g}" if isinstance(value, float) else str(value)


def why_missed(studies: Sequence[Study], most: float) -> str:
    """Why no setting keeps under an error: how near each solver comes, and what to try."""
    words = []
    for study in studies:
        found = []
        for solver, points in by_line(study.points, lambda point: point.solver).items():
            limit = study.reference.get("limits", {}).get(solver)
            known = [error for point in points if (error := point.error.get(study.metric)) is not None]
            if limit is not None and not limit["converges"]:
                found.append(f"{solver} has no limit in sight")
            else:
                sure = f", its limit known to {share(limit['uncertainty'])}" if limit is not None else ""
                found.append(
                    f"{solver} comes to {share(min(known))}{sure}".strip() if known else f"{solver} has no error"
                )
        words.append(f"{study.name}: {', '.join(found)}")
    moving = all(study.axis in ("motion", "reference") for study in studies)
    hint = "try finer --substeps or --particles" if moving else "allow a greater error"
    return f"no setting keeps under an error of {share(most)}: {'; '.join(words)}; {hint}"
