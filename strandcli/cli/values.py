"""Types of options: errors, steps, lists, kinds of animation and layers, angles, sizes of pictures."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import click
from click.shell_completion import CompletionItem

from .complete import listed

MOST_PIXELS = 32_768
"""Along a side of a picture."""


class ErrorType(click.ParamType):
    """An error as a share: ``1%`` or ``0.01``."""

    name = "ERROR"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, float):
            return value
        match = re.fullmatch(r"\s*([0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]{1,3})?)\s*(%?)\s*", str(value), re.ASCII)
        if match is None:
            self.fail(f"'{value}' is not an error, such as 1% or 0.01", param, ctx)
        share = float(match[1]) / (100 if match[2] else 1)
        if not (math.isfinite(share) and 0 < share <= 1):
            self.fail(f"'{value}': an error is more than 0 and at most 100%", param, ctx)
        return share


class BoundsType(click.ParamType):
    """Errors by what they are of: ``1%`` (of motion), ``picture=2%``, ``motion=1%,flip=0.05``."""

    name = "ERRORS"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> dict[str, float]:
        if isinstance(value, dict):
            return value
        found: dict[str, float] = {}
        for word in str(value).split(","):
            name, given, error = word.rpartition("=")
            name = name.strip() if given else BOUNDS[0]
            if name not in BOUNDS:
                self.fail(f"'{name}' has no error; write {', '.join(f'{one}=2%' for one in BOUNDS)}", param, ctx)
            if name in found:
                self.fail(f"'{value}' names two errors of {name}", param, ctx)
            found[name] = ErrorType().convert(error, param, ctx)
        return found


BOUNDS = ("motion", "picture", "flip")
"""What `render --max-error` bounds: where strands are, light in the picture, and what the eye sees of that. The first
is meant where none is named."""


class ListType(click.ParamType):
    """Values separated by commas."""

    def __init__(self, name: str, read: Callable[[str], Any], example: str) -> None:
        self.name, self.read, self.example = name, read, example

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[Any, ...]:
        if isinstance(value, tuple):
            return value
        found = []
        for word in str(value).split(","):
            try:
                found.append(self.read(word.strip()))
            except ValueError as error:
                self.fail(f"{error}; write for instance {self.example}", param, ctx)
        return tuple(dict.fromkeys(found))


class KindsType(click.ParamType):
    """Kinds of animation, separated by commas."""

    name = "KIND"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        if isinstance(value, tuple):
            return value
        kinds = tuple(dict.fromkeys(word.strip().lower().lstrip(".") for word in str(value).split(",")))
        for kind in kinds:
            if kind not in KINDS:
                self.fail(
                    f"'{kind}' is not an animation that can be written; choose gif, webp, mp4, or several with commas",
                    param,
                    ctx,
                )
        return kinds

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        return listed(KINDS, incomplete)


KINDS = ("gif", "webp", "mp4")
"""Animations that can be written."""


class LayersType(click.ParamType):
    """Names of layers, separated by commas."""

    name = "LAYERS"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        if isinstance(value, tuple):
            return value
        names = tuple(word.strip() for word in str(value).split(","))
        if not all(names):
            self.fail(f"'{value}' is not a list of layers such as depth,mask", param, ctx)
        from ..scene.faults import hint, shown
        from ..scene.model import AOVS

        for place, name in enumerate(names):
            if name not in AOVS:
                self.fail(f"unknown layer {shown(name)}; {hint(name, AOVS, 'the layers are')}", param, ctx)
            if name in names[:place]:
                self.fail(f"the layer {shown(name)} is listed twice", param, ctx)
        return names

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        from ..scene.model import AOVS

        return listed(AOVS, incomplete)


def count(low: int, high: int) -> Callable[[str], int]:
    """A reader of whole numbers in a range."""

    def read(word: str) -> int:
        if not re.fullmatch(r"[0-9]{1,9}", word, re.ASCII) or not low <= int(word) <= high:
            raise ValueError(f"'{word}' is not a whole number from {low} to {high}")
        return int(word)

    return read


def step(word: str) -> float:
    """A step in seconds: ``1/240`` or ``0.01``."""
    match = re.fullmatch(r"([0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]{1,3})?)(?:/([0-9]*\.?[0-9]+))?", word, re.ASCII)
    below = float(match[2]) if match and match[2] else 1.0
    seconds = float(match[1]) / below if match and below > 0 else math.nan
    if not (math.isfinite(seconds) and 1e-6 <= seconds <= 10):
        raise ValueError(f"'{word}' is not a step from 1e-6 to 10 seconds")
    return seconds


def metres(word: str) -> float:
    """A length above 0."""
    match = re.fullmatch(r"[0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]{1,3})?", word, re.ASCII)
    length = float(word) if match else math.nan
    if not (math.isfinite(length) and length > 0):
        raise ValueError(f"'{word}' is not a length above 0, metres")
    return length


def word(text: str) -> str:
    """A name."""
    if not text:
        raise ValueError("an empty name")
    return text


class SpanType(click.ParamType):
    """Two angles in degrees, the lesser first, neither beyond ``most``: ``-30,45``."""

    name = "A,B"

    def __init__(self, most: float) -> None:
        self.most = most

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[float, float]:
        if isinstance(value, tuple):
            return value
        try:
            low, high = (float(one) for one in str(value).split(","))
        except ValueError:
            low, high = 1.0, 0.0
        if not -self.most <= low <= high <= self.most:
            words = f"'{value}' is not two angles in degrees, the lesser first, such as -30,45"
            self.fail(f"{words}, within {-self.most:g} and {self.most:g}", param, ctx)
        return low, high


class ColourType(click.ParamType):
    """A colour of sRGB, ``#rrggbb`` or a name of CSS such as ``white``, as three numbers of 8 bits."""

    name = "COLOUR"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, ...]:
        if isinstance(value, tuple):
            return value
        from PIL import ImageColor

        found: tuple[int, ...] = ()
        with suppress(ValueError):
            found = ImageColor.getrgb(str(value).strip())
        if len(found) != 3:
            self.fail(f"'{value}' is not a colour, such as white or '#3060a0' in quotes", param, ctx)
        return found


class SizeType(click.ParamType):
    """A picture's size, ``800x600``, as (width, height)."""

    name = "WxH"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"\s*([0-9]{1,9})\s*[xX×]\s*([0-9]{1,9})\s*", str(value), re.ASCII)
        if match is None:
            self.fail(f"'{value}' is not a width and a height in pixels, such as 800x600", param, ctx)
        width, height = int(match[1]), int(match[2])
        if not (1 <= width <= MOST_PIXELS and 1 <= height <= MOST_PIXELS):
            self.fail(f"'{value}': width and height are from 1 to {MOST_PIXELS} pixels", param, ctx)
        return width, height
