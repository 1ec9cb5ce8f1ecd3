"""The chart of a study: error against run time, both logarithmic, with the Pareto front and what is recommended."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import cycle

from .drawing import XY, Drawing, Patch, Stroke, Text, marker
from .points import Point, by_line
from .report import order_words, seconds, share, step
from .sweep import Study

WIDTH, HEIGHT = 1080, 640
LEFT, TOP, RIGHT, BOTTOM = 84, 76, 272, 64
INK, FAINT, GRID, FINE = "#22262b", "#6b7280", "#dfe3e8", "#f0f2f5"
STYLES = {
    "thesis": ("#d55e00", "diamond"),
    "rod": ("#0072b2", "disc"),
}
COLOURS = ("#e69f00", "#56b4e9", "#5c6066", "#8b5a2b", "#117733", "#882255")
OTHERS = tuple((COLOURS[i % 6], ("disc", "square", "triangle", "diamond")[i % 4]) for i in range(12))
"""Of lines without a style of their own; no two look the same."""
SHORT = {"emitter.particles": "n", "time.substeps": "sub", "rod.iterations": "it"}
PLAIN = {"emitter.strands": "guides", "rules.interaction.cell": "cell"}
"""The same of knobs whose short name needs no explanation."""
KEY = "n: particles, sub: steps a frame, it: iterations"


class Scale:
    """A logarithmic axis from data to drawing units."""

    def __init__(self, values: Sequence[float], begin: float, end: float, room: float = 0.12) -> None:
        low, high = math.log10(min(values)), math.log10(max(values))
        pad = max(room * (high - low), 0.15)
        self.low, self.high, self.begin, self.end = low - pad, high + pad, begin, end

    def __call__(self, value: float) -> float:
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.begin + share * (self.end - self.begin)

    def ticks(self) -> list[tuple[float, bool]]:
        """Values to mark, and whether each has its label: decades, and where they are few 2 and 5 times them too."""
        few = self.high - self.low < 2.6
        found = []
        for decade in range(math.floor(self.low), math.ceil(self.high) + 1):
            for digit in range(1, 10):
                value = digit * 10.0**decade
                if self.low <= math.log10(value) <= self.high:
                    found.append((value, digit == 1 or (few and digit in (2, 5))))
        return found


def chart(study: Study, max_error: float | None = None) -> Drawing:
    """The drawing. Points without an error, or with none at all, are left out."""
    out = Drawing(WIDTH, HEIGHT)
    out.items.append(Text((LEFT, 28), study.title, INK, 19))
    what = f"error ({study.metric}, a share {study.unit}) against run time. Ringed: on the Pareto front"
    if any(knob in point.knobs for point in study.points for knob in SHORT):
        what += f". {KEY}"
    what += "; star: recommended" if max_error else ""
    out.items.append(Text((LEFT, 52), what, FAINT, 13))
    shown = [point for point in study.points if (point.error.get(study.metric) or 0) > 0 and point.seconds > 0]
    if not shown:
        out.items.append(Text((LEFT, TOP + 30), "no run has an error to be shown", FAINT, 15))
        _legend(out, study, {})
        return out
    errors = [point.error[study.metric] or 0.0 for point in shown]
    x = Scale([point.seconds for point in shown], LEFT, WIDTH - RIGHT)
    y = Scale([*errors, *([max_error] if max_error else [])], HEIGHT - BOTTOM, TOP)
    _frame(out, x, y, study)
    places = {id(point): (x(point.seconds), y(error)) for point, error in zip(shown, errors, strict=True)}
    styles = styles_of(study.points)
    _front(out, shown, places)
    if max_error:
        _most(out, y(max_error), max_error)
    for point in shown:
        colour, kind = styles[point.line]
        if point.pareto:
            out.items.append(Patch([places[id(point)]], "#ffffff", INK, 1.4, 9.0))
        out.items.append(marker(kind, places[id(point)], 5.0, colour, "#ffffff", 0.8))
    chosen = [point for point in shown for one in study.recommended if one["knobs"] == dict(point.knobs)]
    if max_error:
        for point in chosen:
            out.items.append(marker("star", places[id(point)], 8.0, "#f2b705", INK, 1.0))
    _labels(out, [*(chosen if max_error else []), *[point for point in shown if point.pareto]], places)
    _legend(out, study, styles)
    return out


def styles_of(points: Sequence[Point]) -> dict[str, tuple[str, str]]:
    """Colour and shape of each line of points."""
    others = cycle(OTHERS)
    return {line: STYLES[line] if line in STYLES else next(others) for line in by_line(points)}


def brief(point: Point) -> str:
    """A setting in a few letters."""
    parts = [f"{word}={point.knobs[knob]}" for knob, word in {**SHORT, **PLAIN}.items() if knob in point.knobs]
    if "dt" in point.knobs:
        parts.append(step(point.knobs["dt"]))
    if not parts:
        parts = [f"{name.rpartition('.')[2]} {value}" for name, value in point.knobs.items() if name != "solver"]
    return ", ".join(parts)


def _frame(out: Drawing, x: Scale, y: Scale, study: Study) -> None:
    left, right, top, bottom = LEFT, WIDTH - RIGHT, TOP, HEIGHT - BOTTOM
    for value, major in x.ticks():
        at = x(value)
        out.items.append(Stroke([(at, top), (at, bottom)], GRID if major else FINE))
        if major:
            out.items.append(Text((at, bottom + 17), seconds(value), FAINT, 12, "middle"))
    for value, major in y.ticks():
        at = y(value)
        out.items.append(Stroke([(left, at), (right, at)], GRID if major else FINE))
        if major:
            out.items.append(Text((left - 9, at), share(value), FAINT, 12, "end"))
    out.items.append(Stroke([(left, top), (left, bottom), (right, bottom)], FAINT, 1.2))
    out.items.append(Text(((left + right) / 2, HEIGHT - 20), "run time", INK, 14, "middle"))
    out.items.append(Text((20, (top + bottom) / 2), f"error, {study.metric}", INK, 14, "middle", True))


def _front(out: Drawing, shown: Sequence[Point], places: dict[int, XY]) -> None:
    """A staircase through the front: what is to be had for at most so much time."""
    corners = sorted(places[id(point)] for point in shown if point.pareto)
    path: list[XY] = []
    for at in corners:
        if path:
            path.append((at[0], path[-1][1]))
        path.append(at)
    path.append((WIDTH - RIGHT, path[-1][1]))
    path.insert(0, (path[0][0], TOP))
    out.items.append(Stroke(path, "#9aa3ad", 1.6))


def _most(out: Drawing, at: float, max_error: float) -> None:
    out.items.append(Stroke([(LEFT, at), (WIDTH - RIGHT, at)], "#c99700", 1.4, 6.0))
    out.items.append(Text((WIDTH - RIGHT - 4, at - 10), f"asked for: {share(max_error)}", "#8a6800", 12, "end"))


def _labels(out: Drawing, points: Sequence[Point], places: dict[int, XY]) -> None:
    """Settings beside points, each where it covers neither a point nor another label; those without room have none."""
    taken = [(x - 7, y - 7, x + 7, y + 7) for x, y in places.values()]
    done = set()
    for point in points:
        if id(point) in done:
            continue
        done.add(id(point))
        text = brief(point)
        x, y = places[id(point)]
        wide, high = 5.8 * len(text), 14.0
        for dx, dy in ((12, -13), (12, 13), (-12 - wide, -13), (-12 - wide, 13), (12, -28), (-12 - wide, 28), (12, 28)):
            box = (x + dx, y + dy - high / 2, x + dx + wide, y + dy + high / 2)
            inside = box[0] > LEFT and box[2] < WIDTH - RIGHT + 6 and box[1] > TOP and box[3] < HEIGHT - BOTTOM
            if inside and not any(_overlap(box, other) for other in taken):
                taken.append(box)
                left = dx < 0
                at = (x - 12 if left else x + 12, y + dy)
                out.items.append(Text(at, text, INK, 11.5, "end" if left else "start"))
                break


def _overlap(a: tuple[float, float, float, float], b: tuple[float, float, float, float]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _legend(out: Drawing, study: Study, styles: dict[str, tuple[str, str]]) -> None:
    x, y = WIDTH - RIGHT + 28, TOP + 8.0
    for line, (colour, kind) in styles.items():
        out.items.append(marker(kind, (x, y), 6.0, colour))
        out.items.append(Text((x + 16, y), line, INK, 14))
        y += 19
        for text in order_words(study.orders, line, study.metric):
            out.items.append(Text((x + 16, y), text, FAINT, 12))
            y += 16
        margin = study.margins.get(line.split(" ")[0])
        if margin is not None:
            known = f"limit known to {share(margin)}" if math.isfinite(margin) else "limit not known"
            out.items.append(Text((x + 16, y), known, FAINT, 12))
            y += 16
        y += 10
    for one in study.absent:
        out.items.append(Text((x, y), f"{one['solver']}: not represented", FAINT, 12))
        y += 18
