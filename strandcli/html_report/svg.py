"""Charts as inline SVG: bars, and a line over frames."""

from __future__ import annotations

import math
from collections.abc import Sequence

from .page import text

COLOURS = ("#c2633a", "#3d7ea6", "#6b9a4f", "#b48a2c", "#8b6bb1", "#4aa39a", "#c05f7e", "#7d8590", "#a3785b", "#5470c6")
WIDTH, HEIGHT = 520.0, 170.0
LEFT, BOTTOM, TOP = 52.0, 22.0, 10.0
MOST_POINTS = 400
"""Points of a line: of long runs the greatest value of each stretch stands for it."""

Point = tuple[float, float]


def bars(rows: Sequence[tuple[str, float, str]]) -> str:
    """A bar a row: name, value, and the words behind it, the longest bar over the whole width."""
    if not rows:
        return ""
    most = max(value for _, value, _ in rows) or 1.0
    height, step, left, room = 14.0, 26.0, 118.0, 150.0
    parts = []
    for place, (name, value, words) in enumerate(rows):
        y, width = place * step, max(1.5, (WIDTH - left - room) * value / most)
        colour = COLOURS[place % len(COLOURS)]
        parts.append(
            f'<text class="strong" x="{left - 10}" y="{y + 12}" text-anchor="end">{text(name)}</text>'
            f'<rect x="{left}" y="{y + 1}" width="{width:.1f}" height="{height}" rx="3" fill="{colour}"/>'
            f'<text x="{left + width + 8:.1f}" y="{y + 12}">{text(words)}</text>'
        )
    return f'<svg class="chart" viewBox="0 0 {WIDTH:g} {len(rows) * step:g}" role="img">{"".join(parts)}</svg>'


def line(points: Sequence[Point], unit: str) -> str:
    """A line of (frame, value), on a scale from 0 to the greatest value. "" for none."""
    if not points:
        return ""
    shown = thinned(points)
    low, high = min(x for x, _ in shown), max(x for x, _ in shown)
    top = _round_up(max(y for _, y in shown))
    at = [f"{_x(x, low, high):.1f},{_y(y, top):.1f}" for x, y in shown]
    if len(at) == 1:
        cx, cy = at[0].split(",")
        drawn = f'<circle cx="{cx}" cy="{cy}" r="3.5" fill="{COLOURS[0]}"/>'
    else:
        drawn = f'<polyline points="{" ".join(at)}" fill="none" stroke="{COLOURS[0]}" stroke-width="1.8" '
        drawn += 'stroke-linejoin="round"/>'
    grid = _grid(low, high, top, unit)
    return f'<svg class="chart" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img">{grid}{drawn}</svg>'


def thinned(points: Sequence[Point]) -> Sequence[Point]:
    """At most so many points; each is the highest of a stretch."""
    if len(points) <= MOST_POINTS:
        return points
    step = -(-len(points) // MOST_POINTS)
    return [max(points[i : i + step], key=lambda point: point[1]) for i in range(0, len(points), step)]


def _grid(low: float, high: float, top: float, unit: str) -> str:
    parts = []
    for share in (0.0, 0.5, 1.0):
        y = _y(share * top, top)
        words = f"{share * top:.3g}{unit}" if share else "0"
        parts.append(f'<line class="grid" x1="{LEFT}" x2="{WIDTH}" y1="{y:.1f}" y2="{y:.1f}"/>'
                     f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{text(words)}</text>')  # fmt: skip
    ends = {low: "start", high: "end"} if high > low else {low: "middle"}
    for frame, anchor in ends.items():
        words = f"frame {frame:g}" if frame == low else f"{frame:g}"
        parts.append(f'<text x="{_x(frame, low, high):.1f}" y="{HEIGHT - 4}" text-anchor="{anchor}">{words}</text>')
    return "".join(parts)


def _x(frame: float, low: float, high: float) -> float:
    return LEFT + (WIDTH - LEFT) * ((frame - low) / (high - low) if high > low else 0.5)


def _y(value: float, top: float) -> float:
    return TOP + (HEIGHT - BOTTOM - TOP) * (1 - value / top)


def _round_up(value: float) -> float:
    """The next of 1, 2, 5 times a power of ten; 1 for nothing."""
    if not value > 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(digit * power for digit in (1, 2, 5, 10) if digit * power >= value * (1 - 1e-9))
