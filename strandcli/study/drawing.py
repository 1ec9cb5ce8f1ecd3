"""A drawing as a list of strokes, shapes and texts, and its two forms: SVG text and a picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

XY = tuple[float, float]

SPELLED = {
    "Δt": "dt", "Γ": "Gamma", "α": "alpha", "β": "beta", "ω": "omega", "²": "^2", "₀": "0", "–": "-", "×": "x",
    "≤": "<=", "π": "pi",
}  # fmt: skip
"""Pillow's own font holds Latin letters only: what stands for others in a picture."""
FINER = 2
"""A picture is drawn this many times larger and scaled down, because Pillow's lines are not smoothed."""


@dataclass(frozen=True)
class Stroke:
    """Straight pieces through points, in drawing units."""

    points: Sequence[XY]
    colour: str
    width: float = 1.0
    dash: float = 0.0
    """Length of dashes and of gaps; 0: none."""


@dataclass(frozen=True)
class Patch:
    """A filled polygon, or a disc where it has one point and a radius."""

    points: Sequence[XY]
    fill: str | None
    edge: str | None = None
    width: float = 1.0
    radius: float = 0.0


@dataclass(frozen=True)
class Text:
    """A line of text; its place is on the middle of its height."""

    at: XY
    text: str
    colour: str
    size: float = 13.0
    anchor: str = "start"
    """start, middle or end."""
    upright: bool = False
    """Turned to read from below."""


@dataclass
class Drawing:
    """Items in the order in which they are drawn; y grows downward."""

    width: int
    height: int
    paper: str = "#ffffff"
    items: list[Stroke | Patch | Text] = field(default_factory=list)

    def svg(self) -> str:
        """As the text of an SVG file."""
        lines = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{self.height}" '
            f'viewBox="0 0 {self.width} {self.height}" font-family="Helvetica, Arial, sans-serif">',
            f'<rect width="100%" height="100%" fill="{self.paper}"/>',
        ]
        lines += [_svg(item) for item in self.items]
        return "\n".join([*lines, "</svg>", ""])

    def picture(self, scale: float = 1.5) -> NDArray[np.uint8]:
        """As pixels (height, width, 3), so many to a drawing unit."""
        from PIL import Image, ImageDraw

        size = (round(self.width * scale), round(self.height * scale))
        image = Image.new("RGB", (size[0] * FINER, size[1] * FINER), self.paper)
        pen = ImageDraw.Draw(image)
        for item in self.items:
            _paint(image, pen, item, scale * FINER)
        return np.asarray(image.resize(size, Image.Resampling.LANCZOS))


def marker(kind: str, at: XY, size: float, fill: str | None, edge: str | None = None, width: float = 1.0) -> Patch:
    """A disc, square, triangle, diamond or star about a point; ``size`` is about its radius."""
    x, y = at
    if kind == "disc":
        return Patch([at], fill, edge, width, size)
    corners, turn, inner = {
        "square": (4, 0.125, 1.0), "diamond": (4, 0.0, 1.0), "triangle": (3, 0.75, 1.0), "star": (10, 0.75, 0.45)
    }[kind]  # fmt: skip
    grown = {"square": 1.2, "triangle": 1.3, "diamond": 1.25, "star": 1.5}[kind] * size
    points = []
    for i in range(corners):
        angle = 2 * math.pi * (turn + i / corners)
        reach = grown * (inner if i % 2 else 1.0)
        points.append((x + reach * math.cos(angle), y + reach * math.sin(angle)))
    return Patch(points, fill, edge, width)


def dashes(points: Sequence[XY], length: float) -> list[tuple[XY, XY]]:
    """The pieces of a polyline that are drawn where dashes and gaps are of one length."""
    out = []
    travelled = 0.0
    for (x0, y0), (x1, y1) in pairwise(points):
        size = math.hypot(x1 - x0, y1 - y0)
        begin = 0.0
        while begin < size:
            turn = (travelled + begin) % (2 * length)
            end = min(size, begin + (length - turn if turn < length else 2 * length - turn) + 1e-9)
            if turn < length:
                a, b = begin / size, end / size
                out.append(((x0 + a * (x1 - x0), y0 + a * (y1 - y0)), (x0 + b * (x1 - x0), y0 + b * (y1 - y0))))
            begin = end
        travelled += size
    return out


def _svg(item: Stroke | Patch | Text) -> str:
    match item:
        case Stroke():
            places = " ".join(f"{x:.1f},{y:.1f}" for x, y in item.points)
            dash = f' stroke-dasharray="{item.dash:g}"' if item.dash else ""
            return (
                f'<polyline points="{places}" fill="none" stroke="{item.colour}" stroke-width="{item.width:g}" '
                f'stroke-linejoin="round"{dash}/>'
            )
        case Patch():
            style = f'fill="{item.fill or "none"}"' + (
                f' stroke="{item.edge}" stroke-width="{item.width:g}"' if item.edge else ""
            )
            if item.radius:
                x, y = item.points[0]
                return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{item.radius:g}" {style}/>'
            places = " ".join(f"{x:.1f},{y:.1f}" for x, y in item.points)
            return f'<polygon points="{places}" {style}/>'
        case Text():
            x, y = item.at
            turned = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if item.upright else ""
            return (
                f'<text x="{x:.1f}" y="{y:.1f}" dy="0.35em" fill="{item.colour}" font-size="{item.size:g}" '
                f'text-anchor="{item.anchor}"{turned}>{escape(item.text)}</text>'
            )


def spelled(text: str) -> str:
    """A text in the letters of Pillow's own font."""
    for letter, words in SPELLED.items():
        text = text.replace(letter, words)
    return text


def _paint(image: Any, pen: Any, item: Stroke | Patch | Text, scale: float) -> None:
    from PIL import Image, ImageDraw, ImageFont

    def up(points: Sequence[XY]) -> list[XY]:
        return [(scale * x, scale * y) for x, y in points]

    match item:
        case Stroke():
            width = max(1, round(scale * item.width))
            if item.dash:
                for piece in dashes(item.points, item.dash):
                    pen.line(up(piece), item.colour, width)
            else:
                pen.line(up(item.points), item.colour, width, joint="curve")
        case Patch() if item.radius:
            x, y = up(item.points)[0]
            r = scale * item.radius
            pen.ellipse((x - r, y - r, x + r, y + r), item.fill, item.edge, max(1, round(scale * item.width)))
        case Patch():
            pen.polygon(up(item.points), item.fill)
            if item.edge:
                pen.line(up([*item.points, item.points[0]]), item.edge, max(1, round(scale * item.width)), "curve")
        case Text():
            font = ImageFont.load_default(scale * item.size)
            text = spelled(item.text)
            x, y = scale * item.at[0], scale * item.at[1]
            if item.upright:
                wide, high = round(font.getlength(text)) + 4, round(2 * scale * item.size)
                strip = Image.new("L", (wide, high), 0)
                ImageDraw.Draw(strip).text((wide / 2, high / 2), text, 255, font, anchor="mm")
                turned = strip.rotate(90, expand=True)
                image.paste(item.colour, (round(x - high / 2), round(y - wide / 2)), turned)
                return
            pen.text((x, y), text, item.colour, font, anchor={"start": "lm", "middle": "mm", "end": "rm"}[item.anchor])
