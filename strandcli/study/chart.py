"""The chart of a study as SVG: error against run time, both logarithmic, with the Pareto front and what is
recommended."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import cycle
from xml.sax.saxutils import escape

from .points import Point, by_line, described
from .report import order_words, seconds, share
from .sweep import Study

XY = tuple[float, float]
WIDTH, HEIGHT = 1080, 640
LEFT, TOP, RIGHT, BOTTOM = 84, 76, 272, 64
INK, FAINT, GRID, FINE = "#22262b", "#6b7280", "#dfe3e8", "#f0f2f5"
STYLES = {"thesis": ("#d55e00", "diamond"), "rod": ("#0072b2", "disc")}
COLOURS = ("#e69f00", "#56b4e9", "#5c6066", "#8b5a2b", "#117733", "#882255")
OTHERS = tuple((COLOURS[i % 6], ("disc", "square", "triangle", "diamond")[i % 4]) for i in range(12))
"""Of lines without a style of their own; no two look the same."""


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


def chart(study: Study, max_error: float | None = None) -> str:
    """The text of an SVG file. Points without an error, or with none at all, are left out."""
    what = f"error ({study.metric}, a share {study.unit}) against run time. Ringed: on the Pareto front"
    what += "; star: recommended" if max_error else ""
    styles = styles_of(study.points)
    items = [text((LEFT, 28), study.title, INK, 19), text((LEFT, 52), what, FAINT, 13)]
    shown = [point for point in study.points if (point.error.get(study.metric) or 0) > 0 and point.seconds > 0]
    if shown:
        items += _plot(study, shown, styles, max_error)
    else:
        items.append(text((LEFT, TOP + 30), "no run has an error to be shown", FAINT, 15))
    items += _legend(study, styles if shown else {})
    return drawing(WIDTH, HEIGHT, items)


def drawing(width: float, height: float, items: Sequence[str]) -> str:
    """The text of an SVG file, white behind its items."""
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}" '
        f'viewBox="0 0 {width:g} {height:g}" font-family="Helvetica, Arial, sans-serif">',
        '<rect width="100%" height="100%" fill="#ffffff"/>', *items, "</svg>", "",
    ])  # fmt: skip


def _plot(
    study: Study, shown: Sequence[Point], styles: dict[str, tuple[str, str]], max_error: float | None
) -> list[str]:
    """Axes, front, points and labels."""
    errors = [point.error[study.metric] or 0.0 for point in shown]
    x = Scale([point.seconds for point in shown], LEFT, WIDTH - RIGHT)
    y = Scale([*errors, *([max_error] if max_error else [])], HEIGHT - BOTTOM, TOP)
    places = {id(point): (x(point.seconds), y(error)) for point, error in zip(shown, errors, strict=True)}
    front = [point for point in shown if point.pareto]
    items = [*_frame(x, y, study), _staircase(sorted(places[id(point)] for point in front))]
    if max_error:
        at = y(max_error)
        items.append(line([(LEFT, at), (WIDTH - RIGHT, at)], "#c99700", 1.4, "6"))
        items.append(text((WIDTH - RIGHT - 4, at - 10), f"asked for: {share(max_error)}", "#8a6800", 12, "end"))
    for point in shown:
        if point.pareto:
            items.append(marker("disc", places[id(point)], 9.0, "#ffffff", INK, 1.4))
        colour, kind = styles[point.line]
        items.append(marker(kind, places[id(point)], 5.0, colour, "#ffffff", 0.8))
    named = [one["parameters"] for one in study.recommended] if max_error else []
    chosen = [point for point in shown if dict(point.parameters) in named]
    items += [marker("star", places[id(point)], 8.0, "#f2b705", INK, 1.0) for point in chosen]
    return items + _labels([*chosen, *front], places)


def styles_of(points: Sequence[Point]) -> dict[str, tuple[str, str]]:
    """Colour and shape of each line of points."""
    rest = cycle(OTHERS)
    return {line: STYLES[line] if line in STYLES else next(rest) for line in by_line(points)}


def text(at: XY, words: str, colour: str, size: float, anchor: str = "start", turn: str = "") -> str:
    """A line of text, its place on the middle of its height."""
    x, y = at
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" dy="0.35em" fill="{colour}" font-size="{size:g}" text-anchor="{anchor}"{turn}>'
        f"{escape(words)}</text>"
    )


def line(points: Sequence[XY], colour: str, width: float = 1.0, dash: str = "none") -> str:
    """Straight pieces through points."""
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return (
        f'<polyline points="{places}" fill="none" stroke="{colour}" stroke-width="{width:g}" stroke-linejoin="round" '
        f'stroke-dasharray="{dash}"/>'
    )


def marker(kind: str, at: XY, size: float, fill: str, edge: str = "none", width: float = 1.0) -> str:
    """A disc, square, triangle, diamond or star about a point; ``size`` is about its radius."""
    x, y = at
    style = f'fill="{fill}" stroke="{edge}" stroke-width="{width:g}"'
    if kind == "disc":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{size:g}" {style}/>'
    corners, turn, inner, grown = {
        "square": (4, 0.125, 1.0, 1.2), "diamond": (4, 0.0, 1.0, 1.25), "triangle": (3, 0.75, 1.0, 1.3),
        "star": (10, 0.75, 0.45, 1.5),
    }[kind]  # fmt: skip
    points = []
    for i in range(corners):
        angle, reach = 2 * math.pi * (turn + i / corners), size * grown * (inner if i % 2 else 1.0)
        points.append(f"{x + reach * math.cos(angle):.1f},{y + reach * math.sin(angle):.1f}")
    return f'<polygon points="{" ".join(points)}" {style}/>'


def _frame(x: Scale, y: Scale, study: Study) -> list[str]:
    left, right, top, bottom = LEFT, WIDTH - RIGHT, TOP, HEIGHT - BOTTOM
    items = []
    for value, major in x.ticks():
        items.append(line([(x(value), top), (x(value), bottom)], GRID if major else FINE))
        items += [text((x(value), bottom + 17), seconds(value), FAINT, 12, "middle")] if major else []
    for value, major in y.ticks():
        items.append(line([(left, y(value)), (right, y(value))], GRID if major else FINE))
        items += [text((left - 9, y(value)), share(value), FAINT, 12, "end")] if major else []
    middle = (top + bottom) / 2
    turn = f' transform="rotate(-90 20 {middle:.1f})"'
    return [
        *items, line([(left, top), (left, bottom), (right, bottom)], FAINT, 1.2),
        text(((left + right) / 2, HEIGHT - 20), "run time", INK, 14, "middle"),
        text((20, middle), f"error, {study.metric}", INK, 14, "middle", turn),
    ]  # fmt: skip


def _staircase(corners: Sequence[XY]) -> str:
    """A line through the front: what is to be had for at most so much time."""
    path = [(corners[0][0], float(TOP))]
    for at in corners:
        path += [(at[0], path[-1][1]), at]
    return line([*path, (WIDTH - RIGHT, path[-1][1])], "#9aa3ad", 1.6)


def _labels(points: Sequence[Point], places: dict[int, XY]) -> list[str]:
    """Settings beside points, each where it covers neither a point nor another label; those without room have none."""
    taken = [(x - 7, y - 7, x + 7, y + 7) for x, y in places.values()]
    items = []
    for at, point in {places[id(point)]: point for point in points}.items():
        words, (x, y) = described(point.parameters).removeprefix(f"{point.solver}, "), at
        wide, high = 5.8 * len(words), 14.0
        for dx, dy in ((12, -13), (12, 13), (-12 - wide, -13), (-12 - wide, 13), (12, -28), (-12 - wide, 28), (12, 28)):
            box = (x + dx, y + dy - high / 2, x + dx + wide, y + dy + high / 2)
            inside = box[0] > LEFT and box[2] < WIDTH - RIGHT + 6 and box[1] > TOP and box[3] < HEIGHT - BOTTOM
            covers = (box[0] < x1 and x0 < box[2] and box[1] < y1 and y0 < box[3] for x0, y0, x1, y1 in taken)
            if inside and not any(covers):
                taken.append(box)
                side = (x - 12, "end") if dx < 0 else (x + 12, "start")
                items.append(text((side[0], y + dy), words, INK, 11.5, side[1]))
                break
    return items


def _legend(study: Study, styles: dict[str, tuple[str, str]]) -> list[str]:
    x, y, items = WIDTH - RIGHT + 28, TOP + 8.0, []
    for name, (colour, kind) in styles.items():
        items += [marker(kind, (x, y), 6.0, colour), text((x + 16, y), name, INK, 14)]
        words = order_words(study.orders, name, study.metric)
        margin = study.margins.get(name.split(" ")[0])
        if margin is not None:
            words.append(f"limit known to {share(margin)}" if math.isfinite(margin) else "limit not known")
        items += [text((x + 16, y + 19 + 16 * i), one, FAINT, 12) for i, one in enumerate(words)]
        y += 29 + 16 * len(words)
    for i, one in enumerate(study.absent):
        items.append(text((x, y + 18 * i), f"{one['solver']}: not represented", FAINT, 12))
    return items
