"""Several studies in one table: a row for each subject and solver, to be read beside one another or pasted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .chart import seconds, share, step
from .points import by_line, cheapest
from .sweep import Study

UNDER = 0.01
"""Error for which the cheapest setting is told where none was asked for."""
HEADS = ("subject", "solver", "least error", "of the", "with", "time", "order in Δt", "in length", "under {most} in")


def rows(studies: Sequence[Study], most: float | None = None) -> list[dict[str, Any]]:
    """A row for each study and line of its chart, and one for each solver that cannot be measured: the least error with
    its setting and seconds, orders where they are to be seen, and the cheapest run under an error."""
    out: list[dict[str, Any]] = []
    for study in studies:
        for line, points in by_line(study.points).items():
            known = [point for point in points if point.error.get(study.metric) is not None]
            best = min(known, key=lambda point: point.error[study.metric] or 0.0, default=None)
            under = cheapest(points, study.metric, most or UNDER, study.margins)
            orders = {
                one["in"]: one["order"] for one in study.orders if one["line"] == line and one["metric"] == study.metric
            }
            out.append(
                {
                    "subject": study.name,
                    "solver": line,
                    "metric": study.metric,
                    "unit": study.unit,
                    "error": None if best is None else best.error[study.metric],
                    "knobs": None if best is None else dict(best.knobs),
                    "seconds": None if best is None else best.seconds,
                    "order_dt": orders.get("dt"),
                    "order_segment": orders.get("segment"),
                    "max_error": most or UNDER,
                    "seconds_under": None if under is None else under.seconds,
                }
            )
        for absent in study.absent:
            out.append({"subject": study.name, "solver": absent["solver"], "not_represented": absent["why"]})
    return out


def to_text(found: Sequence[dict[str, Any]]) -> str:
    """The rows for people, in columns."""
    most = next((one["max_error"] for one in found if "max_error" in one), UNDER)
    lines = [tuple(head.format(most=share(most)) for head in HEADS)]
    notes = []
    for one in found:
        if "not_represented" in one:
            lines.append((one["subject"], one["solver"], "-", *[""] * 6))
            notes.append((len(lines) - 1, one["not_represented"]))
            continue
        nothing = one["error"] is None
        lines.append(
            (
                one["subject"],
                one["solver"],
                "none" if nothing else share(one["error"]),
                one["unit"].removeprefix("of the "),
                "" if nothing else brief(one["knobs"]),
                "" if nothing else seconds(one["seconds"]),
                *["-" if one[key] is None else f"{one[key]:.1f}" for key in ("order_dt", "order_segment")],
                "-" if one["seconds_under"] is None else seconds(one["seconds_under"]),
            )
        )
    widths = [max(len(line[i]) for line in lines) for i in range(len(HEADS))]
    left = (0, 1, 3, 4)
    texts = [
        "  ".join(cell.ljust(width) if i in left else cell.rjust(width) for i, (cell, width) in enumerate(
            zip(line, widths, strict=True)
        )).rstrip()
        for line in lines
    ]  # fmt: skip
    room = sum(widths[:2]) + 4
    for place, why in notes:
        texts[place] = texts[place][:room].ljust(room) + why
    return "\n".join(texts)


def brief(knobs: dict[str, Any]) -> str:
    """What a row's run was set to."""
    words = {"emitter.particles": "particles", "time.substeps": "substeps", "rod.iterations": "iterations"}
    parts = [f"{knobs[path]} {word}" for path, word in words.items() if path in knobs]
    return ", ".join([*parts, *([f"step {step(knobs['dt'])}"] if "dt" in knobs else [])])
