"""A page: its frame, its style, and pieces of it. All text goes through `text`, which escapes it."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from ..errors import one_line

MARK = b"<!doctype html>\n<!-- strandcli report -->\n"
"""First bytes of every report, by which it is known among other files."""
STYLE = """
:root { color-scheme: light dark; --paper: #f6f6f4; --card: #fff; --ink: #1f2328; --faint: #68707a; --line: #e3e4e1;
  --accent: #b4552d; --good: #2f7d4f; --bad: #b3261e; --warn: #8a6100; --warned: #fff6dd; --shade: #efefec; }
@media (prefers-color-scheme: dark) { :root { --paper: #15171a; --card: #1d2024; --ink: #e7e8ea; --faint: #969da6;
  --line: #30343a; --accent: #e08a5f; --good: #6cc08b; --bad: #f2857d; --warn: #e6c068; --warned: #2b2618;
  --shade: #262a2f; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 15px/1.5 system-ui, -apple-system, "Segoe UI",
  Roboto, "Helvetica Neue", "DejaVu Sans", sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 36px 28px 56px; }
h1 { font-size: 30px; line-height: 1.2; margin: 0; letter-spacing: -.02em; overflow-wrap: anywhere; }
h2 { font-size: 12px; text-transform: uppercase; letter-spacing: .09em; color: var(--faint); margin: 0 0 14px; }
p { margin: 0 0 8px; } a { color: inherit; text-decoration: none; } a:hover figcaption { color: var(--accent); }
header { display: flex; flex-wrap: wrap; gap: 6px 16px; align-items: baseline; margin-bottom: 22px; }
header p { flex-basis: 100%; color: var(--faint); margin: 0; }
.badge { border-radius: 99px; padding: 2px 12px; font-size: 13px; font-weight: 600; color: var(--card);
  background: var(--good); }
.badge.bad { background: var(--bad); } .badge.warn { background: var(--warn); }
section { background: var(--card); border: 1px solid var(--line); border-radius: 14px; padding: 22px 24px;
  margin-top: 18px; }
.note { background: var(--warned); border-color: var(--warn); } .note li, .note p { overflow-wrap: anywhere; }
ul { margin: 0; padding-left: 20px; }
.facts { display: grid; grid-template-columns: repeat(auto-fit, minmax(130px, 1fr)); gap: 14px 20px; }
.facts b { display: block; font-size: 22px; font-weight: 600; letter-spacing: -.01em;
  font-variant-numeric: tabular-nums; }
.facts span { color: var(--faint); font-size: 13px; }
.hero { display: block; max-width: 100%; height: auto; border-radius: 10px; margin: 0 auto; }
.sheet { display: grid; grid-template-columns: repeat(auto-fill, minmax(240px, 1fr)); gap: 12px; }
figure { margin: 0; } figure img { display: block; width: 100%; height: auto; border-radius: 8px;
  background: var(--shade); }
figcaption { color: var(--faint); font-size: 12.5px; margin-top: 3px; overflow-wrap: anywhere;
  font-variant-numeric: tabular-nums; }
.hero + .sheet { margin-top: 18px; } .sheet + p { color: var(--faint); margin: 12px 0 0; }
.two { display: grid; grid-template-columns: repeat(auto-fit, minmax(420px, 1fr)); gap: 18px; margin-top: 18px; }
.two section { margin: 0; min-width: 0; }
svg { display: block; width: 100%; height: auto; overflow: visible; }
svg.chart { max-width: 640px; } svg.chart text { fill: var(--faint); font-size: 12px; font-family: inherit; }
svg.chart text.strong { fill: var(--ink); } svg.chart .grid { stroke: var(--line); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 14px; } td, th { text-align: left; padding: 5px 16px 5px 0;
  border-top: 1px solid var(--line); vertical-align: top; overflow-wrap: anywhere; }
tr:first-child td { border-top: 0; }
thead th { border: 0; color: var(--faint); font-weight: 500; white-space: nowrap; }
td { color: var(--faint); } td:first-child { color: var(--ink); }
table:has(thead) td { overflow-wrap: normal; }
table:not(:has(thead)) td:first-child { width: 34%; overflow-wrap: normal; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
details summary { cursor: pointer; color: var(--faint); } details > * + * { margin-top: 12px; }
pre { margin: 0; padding: 14px 16px; background: var(--shade); border-radius: 8px; overflow: auto; max-height: 460px;
  font: 12.5px/1.5 ui-monospace, "SF Mono", Menlo, Consolas, "DejaVu Sans Mono", monospace; }
footer { color: var(--faint); font-size: 13px; margin-top: 26px; text-align: center; }
"""


def text(words: object) -> str:
    """Words as they stand in HTML, in an attribute too: escaped, and on one line."""
    return html.escape(one_line(str(words)), quote=True)


def lines(words: str) -> str:
    """Several lines for <pre>."""
    return "\n".join(text(line) for line in words.splitlines())


def page(title: str, body: Iterable[str]) -> bytes:
    """A whole page. Its policy forbids scripts and everything from elsewhere, should escaping ever fail."""
    policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
    head = (
        f'<html lang="en"><head><meta charset="utf-8"><title>{text(title)}</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{STYLE}</style></head><body><main>"
    )
    return MARK + "\n".join([head, *filter(None, body), "</main></body></html>\n"]).encode("utf-8", "backslashreplace")


def header(title: str, badge: str, kind: str, below: str) -> str:
    """The title, a badge of a kind ("", "warn" or "bad"), and a line below."""
    return f'<header><h1>{text(title)}</h1><span class="badge {kind}">{text(badge)}</span><p>{text(below)}</p></header>'


def section(title: str, inner: str, kind: str = "") -> str:
    """A card with a title; "" for one without content. ``inner`` is HTML."""
    return f'<section class="{kind}"><h2>{text(title)}</h2>{inner}</section>' if inner else ""


def pair(*sections: str) -> str:
    """Cards side by side where there is room."""
    return f'<div class="two">{"".join(sections)}</div>' if any(sections) else ""


def facts(values: Iterable[tuple[str, str]]) -> str:
    """Figures in large type, each with what it is."""
    inner = "".join(f"<div><b>{text(value)}</b><span>{text(name)}</span></div>" for name, value in values)
    return f'<div class="facts">{inner}</div>' if inner else ""


def table(rows: Sequence[Sequence[object]], head: Sequence[str] = (), numbers: Sequence[int] = ()) -> str:
    """A table; ``numbers`` are columns that stand to the right. "" without rows."""
    if not rows:
        return ""

    def row(cells: Sequence[object], tag: str) -> str:
        kinds = ['class="number"' if i in numbers else "" for i in range(len(cells))]
        found = [f"<{tag} {kind}>{text(cell)}</{tag}>" for kind, cell in zip(kinds, cells, strict=True)]
        return f"<tr>{''.join(found)}</tr>"

    top = f"<thead>{row(head, 'th')}</thead>" if head else ""
    return f'<div class="wide"><table>{top}<tbody>{"".join(row(one, "td") for one in rows)}</tbody></table></div>'


def listed(words: Iterable[str]) -> str:
    """Lines of text as a list; "" for none."""
    inner = "".join(f"<li>{text(one)}</li>" for one in words)
    return f"<ul>{inner}</ul>" if inner else ""


def folded(summary: str, inner: str) -> str:
    """What is seen after a click."""
    return f"<details><summary>{text(summary)}</summary><div>{inner}</div></details>"


def footer(version: str) -> str:
    """The last line."""
    words = "this page is self-contained; nothing is fetched and no script runs"
    return f"<footer>strandcli {text(version)}: {words}</footer>"


def is_report(path: Path) -> bool:
    """Whether a file is a report of strandcli's own."""
    with suppress(OSError), path.open("rb") as file:
        return file.read(len(MARK)) == MARK
    return False


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
